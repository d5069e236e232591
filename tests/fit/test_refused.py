"""What cannot be fitted is refused in one sentence that names it, and nothing is left behind."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from phichain.errors import ArrayError, ConvergenceError, IdentificationError, OutputError, UnsupportedError
from phichain.identification import fit, read_measurement
from phichain.scene import Scene, standard_scene
from tests.fit.measured import DOUBLE, KNOWN, START, swung_briefly, system


def columns(**changes: Any) -> dict[str, Any]:
    found = {**swung_briefly().noisy(1e-3, 0), **changes}
    return {name: column for name, column in found.items() if column is not None}


def with_value(name: str, row: int, value: float) -> dict[str, Any]:
    column = columns()[name].copy()
    column[row] = value
    return columns(**{name: column})


@pytest.mark.parametrize("noise", [0.0, 1e-3])
def test_more_parameters_than_the_data_can_tell(noise: float) -> None:
    """A free chain: all masses, inertias and dampers may grow together, and two more changes leave its equations as they are."""
    with pytest.raises(IdentificationError, match="cannot be told apart") as refusal:
        fit(system(DOUBLE), swung_briefly().noisy(noise, 0), START)
    assert {*refusal.value.names} == {f"{name}_{k}" for name in START for k in (1, 2)}
    assert refusal.value.fix == ("mass_1", "mass_2", "com_1") and len(refusal.value.directions) == 3
    fit(system(DOUBLE), swung_briefly().noisy(noise, 0), START, fixed=refusal.value.fix)


def test_the_scale_of_all_masses_is_one_direction_with_equal_shares() -> None:
    start = {"mass": [0.3, 0.2], "inertia": [0.004, 0.0014], "damping": [0.003, 0.0006]}
    with pytest.raises(IdentificationError) as refusal:
        fit(system(DOUBLE), columns(), start, p={"com": [0.15, 0.12]})
    assert "mass_1 +100 %" in refusal.value.directions[0]
    assert "damping_1 +" in refusal.value.directions[0] and "--fix mass_1" in refusal.value.remedy


def test_what_does_nothing_is_named_alone() -> None:
    """A chain at rest tells nothing of its dampers."""
    rest = Scene("measured_rest", 1, mass=1.0, length=0.5, damping="runtime")
    t = np.linspace(0, 1, 40)
    with pytest.raises(IdentificationError, match="does not change what was measured") as refusal:
        fit(system(rest), {"t": t, "theta_1": np.zeros(40)}, {"damping": 0.1}, x0=[0, 0], fit_start=False)
    assert refusal.value.names == ("damping_1",)


@pytest.mark.parametrize(
    ("data", "field", "problem"),
    [
        (lambda: columns(t=None), "data", 'no column "t"'),
        (lambda: {"t": columns()["t"]}, "data", "no measured column"),
        (lambda: columns(theta_3=columns()["theta_1"]), "data", "no column of this chain"),
        (lambda: with_value("theta_2", 7, np.nan), "data.theta_2", "not finite in row 8"),
        (lambda: with_value("t", 5, np.inf), "data.t", "not finite in row 6"),
        (lambda: with_value("t", 5, 0.04), "data.t", "does not rise from row 5 to row 6"),
        (lambda: {k: v[:7] for k, v in columns().items()}, "data.t", "fewer than 8 rows"),
        (lambda: {"t": columns()["t"][:9], "theta_1": columns()["theta_1"][:9]}, "data", "no more numbers than the 9"),
        (lambda: columns(theta_2=np.zeros(3)), "data", "columns of several lengths"),
    ],
)  # fmt: skip
def test_bad_data(data: Any, field: str, problem: str) -> None:
    with pytest.raises(ArrayError, match=problem) as refusal:
        fit(system(DOUBLE), data(), START, fixed=KNOWN)
    assert refusal.value.field == field and "\n" not in str(refusal.value)


@pytest.mark.parametrize(
    ("start", "options", "problem"),
    [
        ({}, {}, "names nothing to fit"),
        ({"masss": 1.0}, {}, 'did you mean "mass"'),
        ({"length": 1.0}, {}, "is no runtime parameter"),
        ({"mass": 1.0}, {}, "has no value"),
        ({**START, "mass": [0.3, 0.2, 0.1]}, {}, "must have shape"),
        ({**START, "mass": [0.3, -0.2]}, {}, "has a sign"),
        ({**START, "mass": [0.3, np.nan]}, {}, "is not finite"),
        ({**START, "damping": 0.0}, {}, "starts from zero"),
        (START, {"p": {"mass": [0.3, 0.2]}}, "to be fitted and to be kept"),
        (START, {"fixed": ["mass_3"]}, "none of the numbers"),
        (START, {"fixed": [f"{name}_{k}" for name in START for k in (1, 2)]}, "leaves nothing"),
        (START, {"x0": [0.0, 0.0]}, "is no state of 4"),
        (START, {"between": "curved"}, "no way from one row"),
    ],
)  # fmt: skip
def test_bad_starts(start: Any, options: Any, problem: str) -> None:
    with pytest.raises(ArrayError, match=problem):
        fit(system(DOUBLE), columns(), start, **options)


def test_nothing_is_left_to_run_time() -> None:
    with pytest.raises(UnsupportedError, match="leaves no parameter to run time"):
        fit(system(standard_scene(2)), columns(), {"mass": 1.0})


def test_another_chain_was_measured() -> None:
    noise = np.random.default_rng(0).standard_normal((2, 40))
    with pytest.raises(ConvergenceError, match="unexplained"):
        fit(system(DOUBLE), {"t": np.linspace(0, 1, 40), "theta_1": noise[0], "theta_2": noise[1]}, START, fixed=KNOWN)


@pytest.mark.parametrize(
    ("text", "error", "problem"),
    [
        ("t,theta_1\n0,1\n0.1,x\n", ArrayError, "line 3"),
        ("t,theta_1\n0,1\n0.1\n", ArrayError, "does not hold 2 numbers in line 3"),
        ("t,theta_1,theta_1\n", ArrayError, "names a column twice"),
        ("", ArrayError, 'no column "t"'),
        ("t,theta_1\n", ArrayError, "fewer than 8 rows"),
        (None, OutputError, "cannot be read"),
    ],
)  # fmt: skip
def test_bad_files(tmp_path, text: str | None, error: type[Exception], problem: str) -> None:
    path = tmp_path / "data.csv"
    if text is not None:
        path.write_text(text)
    with pytest.raises(error, match=problem):
        read_measurement(system(DOUBLE), path)
