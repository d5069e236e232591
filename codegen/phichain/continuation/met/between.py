"""The curve between two points of a branch, and where a test function vanishes on it in one call of a compiled problem."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Callable, Sequence
from operator import mul

import numpy as np

from phichain.continuation.correctors import pseudo_arclength
from phichain.continuation.engine import Engine
from phichain.continuation.events import BranchPoint, TestFunction, watch_of
from phichain.continuation.linear import size
from phichain.continuation.osculating import touched
from phichain.continuation.point import Point, point_at
from phichain.continuation.predictors import hermite, hermite_shares
from phichain.continuation.problem import Problem
from phichain.system import Vector

Curve = Callable[[float], Point]
_NEAR = 3
"""Points on either side of a place that it is guessed from."""
_REGULAR = 0.1
"""Smallest singular value of [J; t], in the larger of those at the ends, below which a point has lost too many digits for others to be guessed from."""


class Between:
    """The curve between two points as a function of arclength, its ends exact.

    The point at s lies in the plane across the chord through the cubic at s; Newton starts in that plane, from the polynomial that
    touches the curve at the nearest points that are known: its ends, what was found before, and points before a.
    """

    def __init__(self, problem: Problem, a: Point, b: Point, engine: Engine, before: Sequence[Point]) -> None:
        """Take the ends, and the points before."""
        self.a, self.b = a, b
        self._problem, self._engine, self._known, self._normal = problem, engine, [*before, a, b], b.y - a.y
        self._across = self._normal / size(self._normal)
        self._ends = [float(self._across @ vector) for vector in (a.y, b.y, a.tangent, b.tangent)]
        self._regular = _REGULAR * max(abs(BranchPoint().value(problem, end)) for end in (a, b))

    def __call__(self, s: float) -> Point:
        """The point at an arclength."""
        problem, engine, a, b = self._problem, self._engine, self.a, self.b
        if s in (a.arclength, b.arclength):
            return a if s == a.arclength else b
        at = bisect_left([point.arclength for point in self._known], s)
        near = touched(problem, self._known[max(0, at - _NEAR) : at + _NEAR], self._across, sum(map(mul, self._ends, hermite_shares(a, b, s))))
        # The chord of two branches, where a step jumped, goes along none of them.
        guess = hermite(a, b, s) if near is None else near
        found = engine.corrector(problem, guess, self._normal, engine.options)
        if found.converged:
            point = found.point(a.tangent, s)
            self._keep(point)
            return point
        # At a branch point the bordered matrix is singular and Newton may fail: the guess is the answer there.
        return point_at(problem, guess, a.tangent, s, found.iterations)

    def _keep(self, point: Point) -> None:
        places = [other.arclength for other in self._known]
        is_regular = abs(BranchPoint().value(self._problem, point)) >= self._regular
        if is_regular and self.a.arclength < point.arclength < self.b.arclength and point.arclength not in places:
            self._known.insert(bisect_left(places, point.arclength), point)

    def zero(
        self, test: TestFunction, values: tuple[float, float], near: tuple[float, float, bool], beyond: Sequence[tuple[float, float]],
        shape: tuple[float, float, Vector] | None = None,
    ) -> tuple[tuple[Point, float], tuple[Point, float], float] | None:
        """The zero of a test function between the ends, in one call where the problem has that compiled.

        Args:
            test: The test function.
            values: Its values at the ends.
            near: How far off the zero may be; how far from a place that is known; and whether that is to have the Jacobian of its own place.
            beyond: Arclengths outside, and the values there.
            shape: Centre, half width and coefficients of the polynomial that the curve is in a neighbourhood, where there is one.

        Returns:
            The point nearest to the zero and the function there; the next one; and the zero's arclength. None where it was not found so.
        """
        compiled, watch = self._problem.compiled, watch_of(self._problem, test)
        if compiled is None or not (watch.what and compiled.watches([watch])) or self._engine.corrector is not pseudo_arclength:
            return None
        found = compiled.zero(self._line, values, beyond, watch, self._engine.options, (*near, self._regular), shape)
        if found is None:
            return None
        rows, at, other, place = found
        points = [(Point.made(**told), value) for told, value, _ in rows]
        for (point, _), (_, _, is_reached) in zip(points, rows, strict=True):
            if is_reached:
                self._keep(point)
        ends = [(self.a, values[0]), (self.b, values[1])]
        return points[at], (points[other] if other >= 0 else ends[other]), place


    @property
    def _line(self) -> list[tuple[float, Vector, Vector]]:
        return [(point.arclength, point.y, point.tangent) for point in (self.a, self.b, *self._known)]

    def places(self, at: Vector) -> Vector:
        """The unknowns at eight arclengths (8, n + 1), scaled, in one call where the problem has that compiled."""
        compiled, found = self._problem.compiled, None
        if compiled is not None and self._engine.corrector is pseudo_arclength:
            found = compiled.places(self._line, at, self._engine.options)
        return np.array([self(s).y for s in at.tolist()]) if found is None else found


def curve(problem: Problem, a: Point, b: Point, engine: Engine, before: Sequence[Point] = ()) -> Between:
    """The curve between two points as a function of arclength, whose points before are known, too."""
    return Between(problem, a, b, engine, before)
