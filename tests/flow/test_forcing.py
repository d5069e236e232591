"""A forced chain: its recurrences proven, its flow against the un-lowered Lagrangian in 50 digits, and its bad input."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mpmath import mp

from phichain import simulate
from phichain.emit.selftest.flow import exact_motion
from phichain.errors import ArrayError, ProofError, UnsupportedError
from phichain.ir.nodes import Const, Store
from phichain.lowering.series import series
from phichain.mechanics import derive
from phichain.pipeline import build
from phichain.proof.prove import prove_recurrences
from phichain.scene import Scene
from tests.flow.flows import compiled
from tests.generated.compiling import STRICT, symbols, write_c
from tests.generated.compiling import compiled as object_of

NOTHING = Const(Fraction(0))
UNEVEN: dict[str, Any] = {"links": 3, "mass": [0.7, 1.9, 0.4], "length": [0.5, 1.3, 0.8], "want": ["propagate"], "variational": True}
COM: dict[str, Any] = {"com": [0.3, 0.9, 0.5]}
CART: dict[str, Any] = {"base": "cart", "cart_mass": 0.9}
JOINTS: dict[str, Any] = {"stiffness": [2.0, 0.5, 1.5], "damping": [0.3, 0.1, 0.2]}
ONE: dict[str, Any] = {"links": 1, "mass": 0.7, "length": 0.5, "want": ["propagate"], "variational": True}
FORCED = {
    scene.name: scene
    for scene in (
        Scene("relative", **UNEVEN, **COM, forced=2),
        Scene("absolute", **UNEVEN, **COM, forced=2, angles="absolute", actuated="all"),
        Scene("adjacent", **UNEVEN, **CART, **JOINTS, forced=3, angles="adjacent", actuated="none"),
        Scene("pushed", **UNEVEN, **CART, **JOINTS, forced="cart", actuated="none", rest_angle=[0.1, 0.2, 0.3]),
        Scene("geared", **UNEVEN, **CART, **JOINTS, forced="cart", armature=0.1),
        Scene("stepped", **UNEVEN, forced="cart", base="cart", drive="acceleration"),
        Scene("shaken", **UNEVEN, **COM, forced="base", base="moving", axis=2),
        Scene("geared_shaken", **UNEVEN, forced="base", base="moving", armature=0.1),
        Scene("one", **ONE, stiffness=1.0, rest_angle=0.2, damping=0.1, forced=1),
        Scene("kapitza", **{**ONE, "mass": "runtime", "length": "runtime"}, forced="base", base="moving", axis=2),
        Scene("tips", **UNEVEN, **CART, forced="cart", space="spatial", axis=2),
        Scene("coms", **UNEVEN, **CART, **COM, forced="cart", space="spatial", actuated="none"),
        Scene("tips_shaken", **UNEVEN, **JOINTS, forced="base", base="moving", space="spatial", axis=2),
        Scene("coms_stepped", **UNEVEN, **COM, forced="cart", base="cart", drive="acceleration", space="spatial", axis=2),
        Scene("loops", 6, mass="runtime", length="runtime", com=0.2, forced=3, want=["propagate"], variational=True, code="loops"),
        Scene("wagons", 5, mass=1.0, length=1.0, com=0.2, base="cart", cart_mass="runtime", code="loops", rest_angle=0.3, stiffness=1.0,
              forced="cart", want=["propagate"]),
    )
}  # fmt: skip


@pytest.mark.parametrize("name", FORCED)
def test_recurrences_are_proven(name: str) -> None:
    model = derive(FORCED[name])
    assert prove_recurrences(model, series(model)).is_exact


def test_no_mutant_of_a_forced_factorisation_passes() -> None:
    """Of the part that forcing adds: what it does to later orders."""
    model = derive(FORCED["relative"])
    whole = series(model)
    stores = [i for i, s in enumerate(whole.factor.body) if isinstance(s, Store) and s.cell.array == "later"]
    refused = 0
    for i in stores:
        body = list(whole.factor.body)
        statement = body[i]
        assert isinstance(statement, Store)
        if statement.value == NOTHING:
            continue
        body[i] = replace(statement, value=NOTHING)
        try:
            prove_recurrences(model, replace(whole, factor=replace(whole.factor, body=tuple(body))))
        except ProofError:
            refused += 1
    assert refused >= 30


@pytest.mark.long
@pytest.mark.parametrize("name", ["adjacent", "shaken", "one", "coms_stepped"])
def test_the_flow_is_the_lagrangians(name: str) -> None:
    """Forwards from t = 0 against extrapolation in 50 digits, the derivatives of which are differences of such motions."""
    scene, (amplitude, omega), t_end = FORCED[name], (3.0, 7.0), 0.02
    propagate = compiled(scene)
    q, v, u = start(scene)

    def exact(q: list[float], v: list[float]) -> np.ndarray:
        inputs = {"q": q, "v": v, "u": u, "amplitude": [amplitude], "omega": [omega]}
        end = exact_motion(scene, {}, inputs, t_end)
        assert end is not None
        return np.array([*end["q"], *end["v"]], float)

    found = propagate(q, v, 0.0, t_end, 1e-15, u=u, forcing=(amplitude, omega), transition=np.eye(scene.nq + scene.nv))
    np.testing.assert_allclose(np.r_[found.q, found.v], exact(q, v), atol=2e-15)
    left = propagate(q, v, 0.0, t_end, 1e-15, u=u, forcing=(0, omega))
    assert np.abs(left.v - found.v).max() > 1e-3
    if scene.is_planar:
        h = 1e-5
        up, down = ([*q[:-1], q[-1] + h], v), ([*q[:-1], q[-1] - h], v)
        slope = (exact(*up) - exact(*down)) / (2 * h)
        np.testing.assert_allclose(found.transition[:, scene.nq - 1], slope, atol=3e-9)


def start(scene: Scene) -> tuple[list[float], list[float], list[float]]:
    """A state away from rest, held inputs beside the forcing."""
    u = [0.3, -0.4, 0.2, 0.1][: scene.nu]
    if scene.is_planar:
        return [0.3, -0.5, 0.7, 0.2][: scene.nq], [0.8, 0.5, -0.4, 0.3][: scene.nq], u
    directions = np.array([[0.6, 0.0, 0.8], [0.0, 0.6, 0.8], [0.28, 0.0, 0.96]])
    rates = np.cross(directions, [[0.2, 0.5, 0.1], [0.3, 0.1, 0.4], [0.5, 0.2, 0.1]])
    cart = 2 * scene.has_cart
    return [0.1] * cart + directions.ravel().tolist(), [0.2] * cart + rates.ravel().tolist(), u


def test_a_phase_is_a_start_and_large_times_keep_it() -> None:
    """The same phase long after the start, omega t known to more digits than a number holds."""
    propagate, omega, t = compiled(FORCED["one"]), 7.25, 123456.78125
    early = float(mp.fmod(mp.mpf(omega) * mp.mpf(t), 2 * mp.pi) / omega)
    late, soon = (propagate([0.3], [0.5], at, at + 2.0, 1e-14, forcing=(2.0, omega)) for at in (t, early))
    assert abs(late.q - soon.q).max() < 5e-11 and abs(late.v - soon.v).max() < 5e-10  # t + 2 is rounded to 1e-11


def test_from_rest_whatever_the_time() -> None:
    """A forced chain that hangs at rest measures its errors by what the forcing does to it."""
    propagate = compiled(FORCED["relative"])
    ends = [propagate(np.zeros(3), np.zeros(3), t, t + 0.5, 1e-13, u=None, forcing=(1.0, 0.0)) for t in (0.0, 1e6)]
    assert all(end.outcome == "done" for end in ends) and abs(ends[0].q).max() > 1e-2
    np.testing.assert_allclose(ends[1].q, ends[0].q, atol=1e-9)


def test_a_stop_and_its_resumption_change_nothing() -> None:
    propagate, options = compiled(FORCED["one"]), {"forcing": (2.0, 5.0)}
    whole = propagate([0.3], [0.5], 0.0, 3.0, 1e-14, **options)
    half = propagate([0.3], [0.5], 0.0, 1.3, 1e-14, **options)
    rest = propagate(half.q, half.v, half.t, 3.0, 1e-14, lost=half.lost, **options)
    np.testing.assert_allclose(np.r_[rest.q, rest.v], np.r_[whole.q, whole.v], atol=1e-13)


@pytest.fixture(scope="module")
def driven() -> Any:
    return build(Scene("driven_pair", 2, mass=1.0, length=0.5, damping=0.1, forced=1, want=["propagate", "propagate_batch"]))


def test_many_trajectories_with_amplitudes_of_their_own(driven: Any) -> None:
    amplitudes, omegas = [0.0, 0.5, 1.5, 1.5, 2.0], [1.0, 3.0, 3.0, 5.0, 5.0]
    q, v, starts = np.tile([0.3, -0.2], (5, 1)), np.tile([0.1, 0.4], (5, 1)), np.linspace(0.0, 0.4, 5)
    many = driven.propagate_batch(q, v, starts, 2.0, 1e-14, forcing=(amplitudes, omegas))
    for k in range(5):
        one = driven.propagate(q[k], v[k], starts[k], 2.0, 1e-14, forcing=(amplitudes[k], omegas[k]))
        np.testing.assert_allclose(many.q[k], one.q, atol=1e-13)
        np.testing.assert_allclose(many.v[k], one.v, atol=1e-12)


@pytest.mark.parametrize(
    ("forcing", "words"),
    [
        (None, "is missing, and the scene is forced by A cos(omega t) (got nothing); give forcing=(amplitude, omega), and (0, 1) for none"),
        (2.0, "is an amplitude without a forcing frequency (got 2.0); give forcing=(amplitude, omega), omega in rad/s"),
        ((1.0, float("nan")), "is not finite"),
        ((1.0, 2.0, 3.0), "is not an amplitude and its frequency"),
        (([1.0, 2.0], 3.0), "holds no single amplitude"),
    ],
)  # fmt: skip
def test_a_forcing_that_is_none(driven: Any, forcing: Any, words: str) -> None:
    with pytest.raises(ArrayError) as caught:
        driven.propagate([0.1, 0.2], [0.0, 0.0], 0.0, 1.0, 1e-12, forcing=forcing)
    assert words in str(caught.value)


def test_what_nothing_forces_and_what_knows_no_forcing(driven: Any) -> None:
    with pytest.raises(UnsupportedError, match="which simulate does not know"):
        simulate(driven, (np.zeros(2), np.zeros(2)), 1.0)
    free = compiled(Scene("free_one", 1, mass=1.0, length=1.0, want=["propagate"]))
    with pytest.raises(ArrayError, match="is given to a chain that nothing forces"):
        free([0.1], [0.0], 0.0, 1.0, 1e-12, forcing=(1.0, 2.0))


@pytest.mark.long
@pytest.mark.parametrize("name", ["shaken", "tips"])
def test_a_phase_goes_through_the_scenes_own_sines_and_cosines(name: str, tmp_path: Path) -> None:
    """With bundled trigonometry no library is asked, and the motion is the same to the last digits; late, too."""
    own = replace(FORCED[name], name=f"{name}_own", trig="bundled", variational=False)
    q, v, u = start(own)
    ends = [
        compiled(scene)(q, v, t, t + 0.5, 1e-14, u=u, forcing=(2.0, 7.25))
        for scene in (own, replace(FORCED[name], variational=False)) for t in (0.0, 1234.5)
    ]  # fmt: skip
    for one, other in zip(ends[:2], ends[2:], strict=True):
        np.testing.assert_allclose(np.r_[one.q, one.v], np.r_[other.q, other.v], rtol=1e-12, atol=1e-12)
    assert np.abs(ends[0].v - ends[1].v).max() > 1e-3
    assert not symbols(write_and_compile(own, tmp_path)).imported & {"sin", "cos", "sincos", "fma"}
    beyond = compiled(own)(q, v, 1e7, 1e7 + 0.5, 1e-14, u=u, forcing=(2.0, 7.25))
    assert beyond.outcome == "not finite"


def write_and_compile(scene: Scene, folder: Path) -> Path:
    """The object of a scene's C, for a processor without a fused product."""
    return object_of(write_c(scene, folder), *STRICT, "-O2", "-fno-math-errno")
