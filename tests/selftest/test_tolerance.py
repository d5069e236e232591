"""Published tolerances: what the problem itself allows, not what the Program happens to lose; the rest is refused."""

from __future__ import annotations

import math
import re
from fractions import Fraction
from itertools import islice

import pytest

from phichain.emit import folder_files
from phichain.emit.selftest import tolerance
from phichain.emit.selftest.case import Case
from phichain.emit.selftest.cases import Selftest, make_selftest
from phichain.emit.selftest.expected import exact_results
from phichain.emit.selftest.tolerance import LIMIT, MARGIN, amplifications, measured
from phichain.errors import EmissionError, SceneError
from phichain.ir.rounded import EPSILON, arithmetic
from phichain.lowering import lower
from phichain.mechanics import derive
from phichain.scene import Scene
from tests.generated.compiling import committed
from tests.selftest.mutated import fused_arithmetic, with_mutant

QUICK = ("firmware_cart_float", "planar3_cart", "planar4_damped_springs", "runtime_double_pendulum", "spatial4_fixed_forward_only")
SPATIAL = Scene(
    "spatial2", 2, space="spatial", base="cart", mass=[1.0, 0.7], length=[0.5, 0.4], cart_mass=1.2, stiffness=2.0,
    want=("forward_dynamics", "direction_dynamics", "state_jacobian", "mass_matrix", "coriolis", "energy", "step", "project"),
)  # fmt: skip


def number(text: str) -> float:
    return float(text.rstrip("fF"))


def kappa(scene: Scene, found: Selftest, name: str) -> float:
    """The largest amplification of a function's cases."""
    program = lower(derive(scene)).wanted[name]
    cases = [case for case in found.cases if case.function == name]
    return max(max(k.values()) for case in cases for k in islice(amplifications(scene, program, case), 8))


# --- what the problem amplifies -------------------------------------------------------------------------------------


@pytest.mark.parametrize("theta", [0.3, 1.3, -2.9])
def test_amplification_of_a_pendulum(theta: float) -> None:
    """a = -(g / l) sin theta: relative changes of g, l and theta add up to 2 + max(1, |theta|) |cot theta|; mass has no part."""
    scene = Scene("one", 1, mass=0.7, length=0.4, gravity=9.7, want=["forward_dynamics"])
    case = Case("forward_dynamics", {}, {"q": [theta], "v": [0.0]}, {}, {})
    found = [k["a"] for k in amplifications(scene, lower(derive(scene)).wanted["forward_dynamics"], case)]
    assert max(found) == pytest.approx(2 + max(1, abs(theta)) * abs(1 / math.tan(theta)), rel=1e-6)
    assert min(found) < 0.999 * max(found)


@pytest.mark.parametrize("theta", [0.3, 0.8])
def test_amplification_of_a_slope(theta: float) -> None:
    """da/dtheta d = -(g / l) cos theta d: g, l and d count once each, theta, moved by units of 1, tan theta times."""
    scene = Scene("one", 1, mass=0.7, length=0.4, gravity=9.7, want=["state_jacobian"])
    program = lower(derive(scene)).wanted["state_jacobian"]
    case = Case("state_jacobian", {}, {"q": [theta], "v": [0.0]}, {"q": [0.9], "v": [0.0]}, {})
    (slope,) = exact_results(scene, program, case)["slope"]
    assert float(slope) == pytest.approx(-9.7 / 0.4 * math.cos(theta) * 0.9, rel=1e-14)
    found = max(k["slope"] for k in amplifications(scene, program, case))
    assert found == pytest.approx(3 + math.tan(theta), rel=1e-6)


# --- refusals ---------------------------------------------------------------------------------------------------------


@pytest.mark.long
@pytest.mark.parametrize("scene", [*map(committed, QUICK), SPATIAL], ids=lambda scene: scene.name)
def test_a_relative_error_in_any_function_is_refused(scene: Scene) -> None:
    """1e-9 in double, 1e-4 in single precision: the tolerance used to follow it."""
    lowered = lower(derive(scene))
    wrong = 1 + Fraction(1, 10**9 if scene.real == "double" else 10**4)
    for name in lowered.wanted:
        with pytest.raises(EmissionError) as caught:
            make_selftest(scene, with_mutant(lowered, name, wrong))
        error, most = caught.value.data["error"], caught.value.data["most"]
        assert caught.value.data["function"] == name and error > most
        assert str(caught.value).startswith(f"target.real: {name} is {error:.1e} off at moderate states")
        assert f"the problem itself allows {most:.1e}" in str(caught.value)


@pytest.mark.parametrize("name", ["planar3_cart", "firmware_cart_float"])
def test_an_output_that_is_no_number_is_refused(name: str) -> None:
    """Also where it is not the first entry: comparisons with NaN are false."""
    scene = committed(name)
    for function in ("energy", "forward_dynamics"):
        if function in scene.want:
            with pytest.raises(EmissionError, match=f"does not hold what {function} computes"):
                make_selftest(scene, with_mutant(lower(derive(scene)), function, None))


def test_two_nearly_equal_angles_are_the_problems_own_loss() -> None:
    """sin(phi_1 - phi_2) at a bend of -8e-5: 170 units of round-off, as one unit in phi moves it."""
    scene = Scene("bend", 2, mass=1.0, length=1.0, want=["coriolis"])
    program = lower(derive(scene)).wanted["coriolis"]
    inputs = {"q": [-1.675154456098586, -8.057590933674419e-05], "v": [-1.6691870725113915, 0.9923528543599107]}
    case = Case("coriolis", {}, inputs, {}, {})
    expected = {name: list(map(float, values)) for name, values in exact_results(scene, program, case).items()}
    case = Case("coriolis", {}, inputs, {}, expected)
    assert max(measured(scene, program, case).values()) > LIMIT * EPSILON["double"]
    assert number(tolerance.tolerance(scene, program, [case])) < 1e-11


# --- no tolerance beyond that ---------------------------------------------------------------------------------------


@pytest.mark.long
@pytest.mark.parametrize("real", ["double", "float"])
@pytest.mark.parametrize("space", ["planar", "spatial"])
@pytest.mark.parametrize("ratio", [1e-2, 1e-4, 1e-8])
def test_masses_near_their_joints(ratio: float, space: str, real: str) -> None:
    """r << l: no scene is refused, and the tolerance is one that the problem explains; 20.0 used to pass."""
    com = [1.1 * ratio, 0.9 * ratio, ratio]
    for name in ("forward_dynamics", "state_jacobian"):
        scene = Scene("near", 3, space=space, mass=[1.1, 0.8, 1.3], length=[1.0, 0.9, 1.2], com=com, real=real, want=[name])
        found = make_selftest(scene, lower(derive(scene)))
        own = max(1.0, kappa(scene, found, name))
        assert number(found.tolerances[name]) <= 1.01 * 10 ** math.ceil(math.log10(MARGIN * LIMIT * own * EPSILON[real]))
        assert number(found.tolerances[name]) < (1e-3 if real == "float" else 1e-10)


@pytest.mark.long
@pytest.mark.parametrize("length", [1e55, 1e76, 1e102, 1e140, 1e153, 1e187, 1e-76, 1e-150])
@pytest.mark.parametrize("mass", [1.0, 1e187, 1e-250])
def test_numbers_of_any_size_give_finite_text_or_a_typed_refusal(length: float, mass: float) -> None:
    """OverflowError, ValueError ("array must not contain infs or NaNs") and -inf in selftest.c used to come of these."""
    want = ["forward_dynamics", "energy", "step", "propagate"]
    for more in ({}, {"base": "cart", "cart_mass": 1.0, "stiffness": 1.0}):
        try:
            scene = Scene("sized", 2, mass=mass, length=length, want=want, **more)
            files = folder_files(scene, lower(derive(scene)))
        except (EmissionError, SceneError) as error:
            assert error.remedy
            continue
        numbers = re.findall(r"[-+]?(?:inf|nan|0x[0-9.a-f]+p[-+]\d+)\b", files["selftest.c"])
        assert len(numbers) > 10 and all(math.isfinite(float.fromhex(x)) for x in numbers)


@pytest.mark.parametrize("scene", [*map(committed, QUICK), SPATIAL], ids=lambda scene: scene.name)
def test_tolerances_have_room_for_fused_multiply_adds(scene: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    """A compiler that contracts and one that does not both pass; no processor is asked."""
    lowered = lower(derive(scene))
    found = make_selftest(scene, lowered)
    monkeypatch.setattr(tolerance, "arithmetic", fused_arithmetic)
    for case in found.cases:
        for output, error in measured(scene, lowered.wanted[case.function], case).items():
            assert error <= number(found.tolerances[case.function]) / 2, (case.function, output)


def test_fused_arithmetic_rounds_once_for_both() -> None:
    tiny = EPSILON["double"]
    for algebra, expected in ((arithmetic("double"), 0.0), (fused_arithmetic("double"), -tiny * tiny)):
        product = algebra.apply("mul", (1 + tiny, 1 - tiny), "")
        assert algebra.apply("sub", (product, 1.0), "") == expected
