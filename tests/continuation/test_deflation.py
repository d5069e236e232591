"""Deflation: Newton does not come back to what is known."""

from __future__ import annotations

import numpy as np
import pytest

from phichain.continuation import Engine, start_on
from phichain.continuation.met.deflation import deflated
from phichain.errors import ConvergenceError
from tests.continuation.problems import problem_of


def three():
    """x (x - 1) (x + 2) = y: three solutions on the line y = 0."""

    def residual(z: np.ndarray) -> np.ndarray:
        x, y = z
        return np.array([x * (x - 1) * (x + 2) - y])

    def jacobian(z: np.ndarray) -> np.ndarray:
        x, _ = z
        return np.array([[3 * x**2 + 2 * x - 2, -1.0]])

    return problem_of(residual, jacobian, ("x", "y"))


def test_all_solutions_are_found_from_one_guess() -> None:
    problem, known, engine, axis = three(), [], Engine(), np.array([0.0, 1.0])
    for _ in range(3):
        known.append(start_on(deflated(problem, known), np.array([-2.8, 0.0]), axis, engine, fixed=True).y)
    assert sorted(float(y[0]) for y in known) == pytest.approx([-2, 0, 1], abs=1e-10)
    with pytest.raises(ConvergenceError):
        start_on(deflated(problem, known), np.array([-2.8, 0.0]), axis, engine, fixed=True)


def test_the_jacobian_is_the_derivative() -> None:
    problem = deflated(three(), [np.array([1.0, 0.0]), np.array([-2.0, 0.1])])
    z = np.array([0.4, -0.7])
    for k, h in enumerate(1e-6 * np.eye(2)):
        slope = (problem.evaluate(z + h).residual - problem.evaluate(z - h).residual) / 2e-6
        assert problem.evaluate(z).jacobian[:, k] == pytest.approx(slope, rel=1e-8)


def test_nothing_known_changes_nothing() -> None:
    problem = three()
    assert deflated(problem, []) is problem
