"""Where a function that has one sign at two points of a branch may have the other one between: foretold from what is known already.

A test function is a polynomial between points that are close enough for a run, up to an error that such polynomials of successive
degrees tell. Where its least height, less that error, lies above zero there is no zero, and nothing is evaluated. An unknown's component
of the tangent is known better than from its values: it is the slope of the unknown, which is known itself.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, Final

import numpy as np

from phichain.continuation.events import BranchPoint, Fold, Level, Quantity, TestFunction
from phichain.continuation.met.between import Curve
from phichain.continuation.point import Point
from phichain.continuation.problem import Problem
from phichain.system import Vector

_BENT: Final = 4.0
"""How many times as far as it bent on the way to a step a function may bend within it."""
_NODES: Final = 6
"""Values that are interpolated."""
_TOUCHED: Final = 4
"""Places that are interpolated with their tangents."""
_FEWER: Final = 3
"""Polynomials of successive degrees through them."""
_DOUBT: Final = 2.0
"""Error of the best of them, in its largest distance from the others."""
_ROUNDS: Final = 10
"""Evaluations on the way down."""
_SAME: Final = 1e-5
"""Share of the step below which a place is one that is known."""
_NOISE: Final = 1e-12
"""Height that is rounding, in 1 and in the largest value nearby: beside a cover of high order nothing else is left of a function."""

Known = Sequence[tuple[Point, float]]
"""Points in order, with a test function's values."""


def may_dip(problem: Problem, test: TestFunction, known: Known, step: int) -> bool:
    """Whether a function, of which little more is known than how it bends, could come down to zero from the point `step` to the next one.

    [J; t] cannot have been singular within a step, but where its sign says so; a level turns at events.
    """
    (a, first), (b, last) = known[step : step + 2]
    if not first * last > 0 or isinstance(test, BranchPoint | Level):
        return False
    length, bent = b.arclength - a.arclength, 0.0
    slope = (last - first) / length
    if step > 0:
        other, value = known[step - 1]
        bent = abs(slope - (first - value) / (a.arclength - other.arclength)) / (b.arclength - other.arclength)
    if step + 2 < len(known):
        other, value = known[step + 2]
        bent = max(bent, abs(slope - (value - last) / (other.arclength - b.arclength)) / (other.arclength - a.arclength))
    deep = bent * length * length / 4
    if isinstance(test, Fold):
        # The mean of a slope is known from both its ends.
        fold = _component(problem, test)
        deep = max(deep, 1.5 * abs((b.y[fold] - a.y[fold]) / length - (first + last) / 2))
    return min(abs(first), abs(last)) < _BENT * deep


def dip_between(problem: Problem, test: TestFunction, known: Known, step: int, between: Curve) -> list[tuple[Point, Point]]:
    """Two brackets of zeros between two of some points, where a function has one sign; none where it has no other between.

    Args:
        problem: What is continued.
        test: The test function.
        known: Points, with its values.
        step: It is looked between this one of them and the next one.
        between: The curve between these.
    """
    (a, first), (b, last) = known[step : step + 2]
    nodes = [(point, value) for point, value in known if math.isfinite(value)]
    sign, noise = math.copysign(1.0, first), _NOISE * max(1.0, *(abs(value) for _, value in nodes))
    fold = _component(problem, test) if isinstance(test, Fold) else None
    for turn in range(_ROUNDS):
        place = _lowest(nodes, a, b, sign, fold, noise)
        if turn == 0 and isinstance(test, Quantity) and test.in_pairs:
            # Where a square would be zero that has both values: two multipliers that pass each other make it one, whatever the others do.
            place = a.arclength + (b.arclength - a.arclength) / (1 + math.sqrt(last / first))
        if place is None:
            return []
        point = between(place)
        value = test.value(problem, point)
        if not math.isfinite(value):
            return []
        k = next(k for k, (node, _) in enumerate(nodes) if node.arclength > place)
        if sign * value < -noise:
            return [(nodes[k - 1][0], point), (point, nodes[k][0])]
        nodes.insert(k, (point, value))
    return []


def _component(problem: Problem, fold: Fold) -> int:
    return problem.parameter if fold.component is None else fold.component


def _lowest(nodes: Known, a: Point, b: Point, sign: float, fold: int | None, noise: float) -> float | None:
    """The place between two points at which a function may be least; None where it is above zero everywhere, or known there."""
    length = b.arclength - a.arclength
    middle = (a.arclength + b.arclength) / 2
    near = sorted(nodes, key=lambda node: abs(node[0].arclength - middle))
    fits = _slopes(near[:_TOUCHED], a, b, fold) if fold is not None else _values(near[:_NODES], middle, length / 2)
    best, *rough = (sign * fit for fit in fits)
    turns = [root for fit in (best, *rough) for root in np.roots(np.polyder(fit)).tolist()]
    taken = [2 * (node.arclength - middle) / length for node, _ in nodes]
    places = np.array([x.real for x in turns if abs(x.imag) < _SAME and abs(x.real) < 1 and min(abs(x.real - own) for own in taken) > _SAME])
    if places.size == 0:
        return None
    heights = np.polyval(best, places)
    error = np.max([np.abs(heights - np.polyval(fit, places)) for fit in rough], axis=0)
    least = heights - _DOUBT * error
    if np.min(least) > -noise:
        return None
    at = int(np.argmin(least))
    return float(middle + places[at] * length / 2)


def _values(near: Known, middle: float, half: float) -> list[Vector]:
    """The polynomials through all of some values, through all but the farthest, and through all but the two farthest, over the distance from the middle."""
    x = np.array([(point.arclength - middle) / half for point, _ in near])
    f = np.array([value for _, value in near])
    return [_solved(np.vander(x[:count]), f[:count]) for count in range(len(x), max(1, len(x) - _FEWER), -1)]


def _slopes(near: Known, a: Point, b: Point, fold: int) -> list[Vector]:
    """The slopes of the polynomials that touch an unknown at all of some points and at all but the farthest, over the distance along the chord."""
    chord = b.y - a.y
    half = np.linalg.norm(chord) / 2
    axis, centre = chord / (2 * half), (a.y + b.y) / 2
    fits: list[Vector] = []
    for points in (near, near[:-1]):
        own = [point for point, _ in points if point.tangent @ axis > 1 / 2]
        x = np.array([axis @ (point.y - centre) / half for point in own])
        rows = np.vander(x, 2 * len(own))
        slopes = np.hstack([rows[:, 1:] * np.arange(2 * len(own) - 1, 0, -1), np.zeros((len(own), 1))])
        given = [[point.y[fold] - centre[fold] for point in own], [half * point.tangent[fold] / (axis @ point.tangent) for point in own]]
        fits.append(np.polyder(_solved(np.vstack([rows, slopes]), np.ravel(given))) / half)
    return fits


def _solved(rows: Any, right: Any) -> Vector:
    found: Vector = np.linalg.lstsq(rows, right, rcond=None)[0]
    return found
