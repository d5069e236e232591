"""selftest.c of scenes whose numbers are far from 1: it passes where the code is right, and refuses what says nothing."""

from __future__ import annotations

from pathlib import Path

import pytest

from phichain.emit.selftest.cases import make_selftest
from phichain.errors import EmissionError
from phichain.lowering import lower
from phichain.mechanics import derive
from phichain.scene import Scene
from tests.generated.compiling import run, write_all

STIFF = {
    "light_damped": Scene(
        "light_damped", 2, space="spatial", mass=[1.2e-6, 0.55], length=[10.2, 9.3], com=[1.1e-3, 8.7e-5],
        damping=[1.5, 0.16], want=["step"], code="loops",
    ),
    "light_spring": Scene(
        "light_spring", 2, mass=[0.18, 0.31], length=[3.0, 0.5], com=[1e-4, 2e-5], stiffness=[8.2, 7.7],
        want=["step"], real="float", code="unrolled",
    ),
}  # fmt: skip
"""Fast joints: a step of 2^-14 s is far beyond the stability of RK4, and what it returns grows without bound."""


@pytest.mark.parametrize("name", STIFF)
def test_the_step_is_tested_where_it_is_stable(name: str, tmp_path: Path) -> None:
    scene = STIFF[name]
    tolerance = make_selftest(scene, lower(derive(scene))).tolerances["step"]
    assert float(tolerance.rstrip("F")) <= (1e-4 if scene.real == "float" else 1e-8)
    folder = write_all(scene, tmp_path)
    run("cc", "-std=c99", f"{scene.name}.c", "selftest.c", "-lm", "-o", "selftest", cwd=folder)
    assert "FAILED" not in run("./selftest", cwd=folder)


def test_a_type_too_small_for_the_scene_is_refused() -> None:
    # c_22 = 1e-35 fits a float, a product with another such number does not.
    scene = Scene("tiny", 2, mass=[1.0, 1e-18], length=[1.0, 1e-8], com=[0.5, 3e-9], stiffness=1e30, actuated="all", real="float")
    with pytest.raises(EmissionError, match=r"^target\.real: does not hold what forward_dynamics computes") as caught:
        make_selftest(scene, lower(derive(scene)))
    assert caught.value.remedy.startswith('set real = "double", or choose units')


def test_what_is_zero_is_expected_to_be_zero() -> None:
    """One absolute angle has no velocity terms: what fifty digits leave of their sum is no scale to judge by."""
    scene = Scene("one", 1, mass=0.7, length=0.9, com=0.3, want=["coriolis", "gravity_torque"])
    made = make_selftest(scene, lower(derive(scene)))
    assert [case.expected["out"] for case in made.cases if case.function == "coriolis"] == [[0.0]] * 3
    assert made.tolerances["coriolis"] == made.tolerances["gravity_torque"] == "4.0e-15"


def test_what_is_small_in_its_units_stays() -> None:
    scene = Scene("grain", 1, mass=1e-80, length=0.9, com=0.3, want=["gravity_torque"])
    made = make_selftest(scene, lower(derive(scene)))
    assert all(0.0 < abs(case.expected["out"][0]) < 1e-78 for case in made.cases)
