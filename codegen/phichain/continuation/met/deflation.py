"""Deflation: a problem whose known solutions Newton is pushed away from.

With m(y) = prod_k (1 / |y - y_k|^2 + 1) the problem m(y) F(y) = 0 has the solutions of F but the known ones
y_k, at which it does not tend to zero along any way across the curve.

Source: P. Farrell, A. Birkisson, S. Funke, Deflation techniques for finding distinct solutions of nonlinear
partial differential equations, SIAM J. Sci. Comput. 37 (2015) A2026-A2045.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from phichain.continuation.problem import Evaluation, Problem
from phichain.system import Vector


def deflated(problem: Problem, known: Sequence[Vector]) -> Problem:
    """The same problem without its known solutions.

    Args:
        problem: What is solved.
        known: Scaled solutions y_k (n + 1,).
    """
    if not known:
        return problem
    places = np.array(known)

    def evaluate(z: Vector) -> Evaluation:
        residual, jacobian, extra = problem.evaluate(z)
        away = z / problem.sizes - places
        squares = np.sum(away**2, axis=1)
        with np.errstate(divide="ignore", invalid="ignore"):
            factors = 1 / squares + 1
            whole = float(np.prod(factors))
            # d log m / dy = sum_k -2 (y - y_k) / (|y - y_k|^4 m_k)
            slope = whole * np.sum(-2 * away / (squares**2 * factors)[:, None], axis=0) / problem.sizes
        return Evaluation(whole * residual, whole * jacobian + np.outer(residual, slope), extra)

    return replace(problem, evaluate=evaluate)
