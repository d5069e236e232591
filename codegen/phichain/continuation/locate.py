"""Locating events between two points of a branch: a bracketed root of each test function along the curve."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from scipy.optimize import brentq

from phichain.continuation.branch import Special
from phichain.continuation.engine import Engine
from phichain.continuation.events import BranchPoint, TestFunction
from phichain.continuation.point import Point, scaled_jacobian, tangent_of
from phichain.continuation.predictors import hermite
from phichain.continuation.problem import Problem, relative_residual

NEIGHBOURHOOD = 1e-5
"""How close to a zero of det [J; t^T], in steps, it is looked at to see whether it vanishes or jumps."""


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
    """False when det [J; t^T] has another sign at `b` than at `a` without vanishing: b is on another branch.

    At a branch point the determinant crosses zero linearly and the curve goes on: close to the zero, on both sides,
    the corrector converges and finds values as small as the distance. Where a step jumped from one branch to its
    neighbour, the planes between them meet neither branch nearby, or the values stay as large as the gap.
    """
    test = BranchPoint()
    ends = test.value(problem, a), test.value(problem, b)
    if ends[0] * ends[1] >= 0:
        return True
    zero = _root(problem, a, b, test, engine).arclength
    width = NEIGHBOURHOOD * (b.arclength - a.arclength)
    # So close to a singular matrix Newton's corrections end at a plateau of round-off above the usual tolerance.
    loose = replace(engine, options=replace(engine.options, tol=max(engine.options.tol, 1e-8)))
    between = _curve(problem, a, b, loose)
    sides = [between(float(np.clip(zero + d, a.arclength, b.arclength))) for d in (-width, width)]
    small = 5 * NEIGHBOURHOOD * max(abs(end) for end in ends)
    return all(side.residual < 1e-6 and abs(test.value(problem, side)) <= small for side in sides)


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
        z = guess * problem.sizes
        jacobian = scaled_jacobian(problem, guess)
        residual = relative_residual(problem.residual(z), problem.jacobian(z), z)
        return Point(guess, tangent_of(jacobian, a.tangent), s, jacobian, residual, found.iterations, ())

    return between
