"""Locating events between two points of a branch: a bracketed root of each test function along the curve."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np
from scipy.optimize import brentq

from phichain.continuation.branch import Special
from phichain.continuation.events import BranchPoint, TestFunction
from phichain.continuation.point import Point, scaled_jacobian, tangent_of
from phichain.continuation.predictors import hermite
from phichain.continuation.problem import Problem, relative_residual

SMOOTH = 1e-6
"""A test function is taken to vanish when it falls to this share of its values at the ends of the step."""

if TYPE_CHECKING:
    from phichain.continuation.core import Engine


def locate(
    problem: Problem, a: Point, b: Point, tests: Sequence[TestFunction], engine: Engine, index: int
) -> tuple[list[Special], Point | None]:
    """The events between two successive points.

    Places in between are guessed on the cubic through both points and corrected onto the curve; Brent's method
    (secant and inverse quadratic steps inside a bisection bracket) finds the zero of the test function.

    Args:
        problem: What is continued.
        a: Earlier point.
        b: Later point.
        tests: TestFunction functions.
        engine: Corrector and options.
        index: Index of `a` in its branch.

    Returns:
        The events in order, none after a terminal one; and the point of the terminal one, or None.
    """
    found: list[tuple[Special, Point, bool]] = []
    for test in tests:
        before, after = test.value(problem, a), test.value(problem, b)
        # A test that starts at zero is not crossed; one that arrives at zero is.
        if before * after < 0 or (after == 0 and before != 0):
            at = b if after == 0 else _root(problem, a, b, test, engine)
            special = Special(test.name, index, at.z(problem), at.arclength, test.value(problem, at))
            found.append((special, at, test.terminal))
    found.sort(key=lambda item: item[0].arclength)
    ends = [k for k, (_, _, terminal) in enumerate(found) if terminal]
    if not ends:
        return [special for special, _, _ in found], None
    kept = found[: ends[0] + 1]
    return [special for special, _, _ in kept], kept[-1][1]


def is_crossed_smoothly(problem: Problem, a: Point, b: Point, engine: Engine) -> bool:
    """False when det [J; t^T] has another sign at `b` than at `a` but no zero in between: b is on another branch."""
    test = BranchPoint()
    before, after = test.value(problem, a), test.value(problem, b)
    if before * after >= 0:
        return True
    zero = test.value(problem, _root(problem, a, b, test, engine))
    return abs(zero) <= SMOOTH * max(abs(before), abs(after))


def _root(problem: Problem, a: Point, b: Point, test: TestFunction, engine: Engine) -> Point:
    between = _curve(problem, a, b, engine)
    spacing = 4 * np.finfo(float).eps
    s = brentq(
        lambda s: test.value(problem, between(s)),
        a.arclength,
        b.arclength,
        xtol=spacing * (1 + b.arclength),
        rtol=spacing,
    )
    return between(float(s))


def _curve(problem: Problem, a: Point, b: Point, engine: Engine) -> Callable[[float], Point]:
    """The curve between two points as a function of arclength, its ends exact."""

    def between(s: float) -> Point:
        if s in (a.arclength, b.arclength):
            return a if s == a.arclength else b
        guess = hermite(a, b, s)
        found = engine.corrector(problem, guess, b.y - a.y, engine.options)
        if found.converged:
            tangent = tangent_of(found.jacobian, a.tangent)
            return Point(
                found.y, tangent, s, found.jacobian, found.residual, found.iterations, found.corrections
            )
        # At a branch point the bordered matrix is singular and Newton may fail: the cubic is the answer there.
        jacobian = scaled_jacobian(problem, guess)
        z = guess * problem.sizes
        residual = relative_residual(problem.residual(z), problem.jacobian(z), z)
        return Point(
            guess, tangent_of(jacobian, a.tangent), s, jacobian, residual, found.iterations, found.corrections
        )

    return between
