"""Steps that leap over places where [J; t] is singular: curves from which others branch off at places that are chosen."""

from __future__ import annotations

import numpy as np
import pytest

from phichain.continuation import Branch, BranchPoint, Engine, Level, Options, follow, start_on
from tests.continuation.problems import problem_of

OTHERS = [(1.0271, 0.0167, 0.0739, 1.0), (0.5439, 0.1731, 0.2589, 0.0), (0.9692, 0.1095, 0.3598, 1.0), (0.5858, 0.281, 0.0533, 1.0)]
"""Where two branches leave, how far from each other, how near to them that is felt, and how strongly the curve bends."""


def run(first: float, apart: float, near: float, bend: float, step_max: float) -> Branch:
    """Along y = bend x^2, left by branches at `first` and `apart` beyond, so that det [J; t] goes as x_k / root(x_k^2 + near^2) of both distances x_k."""
    places = np.array([first, first + apart])

    def residual(z: np.ndarray) -> np.ndarray:
        away = z[0] - places
        return np.array([np.prod(away / np.hypot(away, near)) * (z[1] - bend * z[0] ** 2)])

    def jacobian(z: np.ndarray) -> np.ndarray:
        away = z[0] - places
        felt, slope = away / np.hypot(away, near), near**2 / np.hypot(away, near) ** 3
        return np.array([[(slope @ felt[::-1]) * (z[1] - bend * z[0] ** 2) - 2 * bend * z[0] * np.prod(felt), np.prod(felt)]])

    problem, along = problem_of(residual, jacobian, ("x", "y")), np.array([1.0, 0.0])
    engine = Engine(options=Options(step=min(0.02, step_max), step_max=step_max))
    return follow(problem, start_on(problem, np.zeros(2), along, engine), engine, [BranchPoint(), Level(lambda z: float(z[0]), 2.0, "far")])


@pytest.mark.parametrize("step_max", [2.0, 0.1, 0.01])
@pytest.mark.parametrize(("first", "apart", "near", "bend"), OTHERS)
def test_a_leap_over_one_place_is_none_over_two(first: float, apart: float, near: float, bend: float, step_max: float) -> None:
    """The sign of det [J; t] is the same behind two places as before them, and the Jacobian as if it had hardly changed."""
    branch = run(first, apart, near, bend, step_max)
    assert [event.z[0] for event in branch.located("branch point")] == pytest.approx([first, first + apart], abs=1e-9)
    assert len(branch) < 60 + 5 / step_max
