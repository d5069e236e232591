"""Locating events between two points of a branch: a bracketed root of each test function along the curve."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from scipy.optimize import brentq

from phichain.continuation.branch import Special
from phichain.continuation.engine import Engine
from phichain.continuation.events import TestFunction
from phichain.continuation.point import Point, tangent_of
from phichain.continuation.predictors import hermite
from phichain.continuation.problem import Problem, relative_residual


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
        tests: Test functions.
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
            at = b if after == 0 else root(problem, a, b, test, engine)
            special = Special(
                test.name, index, at.z(problem), at.arclength, test.value(problem, at), at.multipliers
            )
            found.append((special, at, test.terminal))
    found.sort(key=lambda item: item[0].arclength)
    ends = [k for k, (_, _, terminal) in enumerate(found) if terminal]
    if not ends:
        return [special for special, _, _ in found], None
    kept = found[: ends[0] + 1]
    return [special for special, _, _ in kept], kept[-1][1]


def root(problem: Problem, a: Point, b: Point, test: TestFunction, engine: Engine) -> Point:
    """The point between two of a curve at which a test function vanishes that has two signs at them."""
    between = curve(problem, a, b, engine)
    spacing = 4 * np.finfo(float).eps
    s = brentq(
        lambda s: test.value(problem, between(s)),
        a.arclength,
        b.arclength,
        xtol=spacing * (1 + b.arclength),
        rtol=spacing,
    )
    return between(float(s))


def curve(problem: Problem, a: Point, b: Point, engine: Engine) -> Callable[[float], Point]:
    """The curve between two points as a function of arclength, its ends exact."""

    def between(s: float) -> Point:
        if s in (a.arclength, b.arclength):
            return a if s == a.arclength else b
        guess = hermite(a, b, s)
        found = engine.corrector(problem, guess, b.y - a.y, engine.options)
        if found.converged:
            return found.point(a.tangent, s)
        # At a branch point the bordered matrix is singular and Newton may fail: the cubic is the answer there.
        residual, jacobian, extra = problem.at(guess)
        size = relative_residual(residual, jacobian, guess)
        return Point(guess, tangent_of(jacobian, a.tangent), s, jacobian, size, found.iterations, (), extra.multipliers)

    return between
