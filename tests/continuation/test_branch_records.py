"""Branches as records and files, and what Options and Problems refuse."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from phichain.continuation import Branch, Engine, Extra, Fold, Level, Options, Problem, follow, start_on
from phichain.errors import ArrayError, OutputError, ToleranceError
from tests import tables
from tests.continuation.problems import PARABOLA


def test_the_point_limit_and_a_frozen_record() -> None:
    start = start_on(PARABOLA, np.array([-1.0, -1.0]), np.array([1.0, 0.0]), Engine())
    branch = follow(PARABOLA, start, Engine(options=Options(max_points=7)))
    assert len(branch) == 7 and branch.status == "points" and "max_points = 7" in branch.reason
    with pytest.raises(dataclasses.FrozenInstanceError):
        branch.status = "other"  # type: ignore[misc]
    assert branch.column("l") is not None
    with pytest.raises(ArrayError, match="use one of x, l"):
        branch.column("mu")


def test_files_round_trip(tmp_path) -> None:
    problem = dataclasses.replace(PARABOLA, energy=lambda z: z[0] ** 2)
    start = start_on(problem, np.array([-1.0, -1.0]), np.array([1.0, 0.0]), Engine())
    branch = follow(problem, start, tests=[Fold(), Level(lambda z: z[0], 1.0)], name="parabola")
    copy = Branch.from_npz(branch.to_npz(tmp_path / "branch.npz"))
    for name in ("points", "arclength", "tangent", "residual", "iterations", "scale", "energy"):
        assert np.array_equal(getattr(copy, name), getattr(branch, name))
    assert (copy.name, copy.names, copy.status, copy.reason) == (
        branch.name,
        branch.names,
        branch.status,
        branch.reason,
    )
    assert [(e.kind, e.index, e.arclength, e.value) for e in copy.events] == [
        (e.kind, e.index, e.arclength, e.value) for e in branch.events
    ]
    lines = tables.lines(branch.to_csv(tmp_path / "branch.csv"))
    assert lines[0] == "arclength,x,l,energy,residual,iterations" and len(lines) == len(branch) + 1
    assert float(lines[3].split(",")[1]) == branch.points[2, 0]
    assert "fold at s" in str(branch) and "parabola" in str(branch)
    with pytest.raises(OutputError, match="no Branch"):
        Branch.from_npz(tmp_path / "branch.csv")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"step": 0}, "options.step: must be positive"),
        ({"step_min": -1e-3}, "options.step_min"),
        ({"step_max": np.inf}, "options.step_max"),
        ({"tol": np.nan}, "options.tol"),
        ({"step": 1.0, "step_max": 0.5}, "between step_min"),
        ({"aim_angle": 0.5}, "between aim_angle"),
        ({"max_angle": 2.0}, "between aim_angle"),
        ({"max_points": 1}, "at least 2"),
        ({"max_iterations": 1}, "max_iterations"),
    ],
)
def test_options_are_checked_when_made(arguments, words) -> None:
    with pytest.raises(ToleranceError, match=words):
        Options(**arguments)


@pytest.mark.parametrize(
    ("build", "words"),
    [
        (lambda: dataclasses.replace(PARABOLA, scale=np.array([1.0])), "2 positive sizes"),
        (lambda: dataclasses.replace(PARABOLA, scale=np.array([1.0, 0.0])), "2 positive sizes"),
        (lambda: dataclasses.replace(PARABOLA, parameter=2), "no unknown"),
        (lambda: PARABOLA.check(np.zeros(3)), "2 finite numbers"),
        (lambda: Problem(lambda z: (z, z), ("x", "l")).check(np.zeros(2)), r"\(F, J, extra\)"),
        (lambda: Extra(np.ones((2, 2))), "no vector of complex numbers"),
        (lambda: Extra(["a"]), "no vector of complex numbers"),
        (lambda: PARABOLA.check(np.array([0, np.nan])), "2 finite numbers"),
        (
            lambda: dataclasses.replace(PARABOLA, names=("x", "y", "l"), scale=None).check(np.zeros(3)),
            "shapes",
        ),
    ],
)
def test_problems_are_checked(build, words) -> None:
    with pytest.raises(ArrayError, match=words):
        build()
