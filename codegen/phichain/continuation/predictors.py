"""Predictors: a guess for the next point. A predictor is any callable `(points, step) -> guess`.

`points` are the points so far, newest last; guesses are in scaled unknowns.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from phichain.continuation.osculating import osculating as touching
from phichain.continuation.point import Point
from phichain.system import Vector

Predictor = Callable[[Sequence[Point], float], Vector]
TOUCHED = 5
"""Points that the longest-sighted predictor looks back on."""


def tangent(points: Sequence[Point], step: float) -> Vector:
    """Along the tangent: y + step dy/ds; error of second order in the step."""
    return points[-1].y + step * points[-1].tangent


def secant(points: Sequence[Point], step: float) -> Vector:
    """Along the chord of the last two points (the tangent at the first): no tangent needed."""
    if len(points) < 2:
        return tangent(points, step)
    chord = points[-1].y - points[-2].y
    return points[-1].y + step * chord / np.linalg.norm(chord)


def cubic(points: Sequence[Point], step: float) -> Vector:
    """Along the cubic through the last two points and their tangents; error of fourth order in the step."""
    if len(points) < 2:
        return tangent(points, step)
    return hermite(points[-2], points[-1], points[-1].arclength + step)


def osculating(points: Sequence[Point], step: float) -> Vector:
    """Along the polynomial that touches the curve at the last points; error of the order of twice their number."""
    last = points[-1]
    ahead = touching(points[-TOUCHED:], last.tangent, float(last.tangent @ last.y) + step)
    return tangent(points, step) if ahead is None else ahead


def hermite(a: Point, b: Point, arclength: float) -> Vector:
    """Value at `arclength` of the cubic with the places and tangents of two points."""
    first, last, leaving, arriving = hermite_shares(a, b, arclength)
    return first * a.y + last * b.y + leaving * a.tangent + arriving * b.tangent


def hermite_shares(a: Point, b: Point, arclength: float) -> tuple[float, float, float, float]:
    """What places and tangents of two points count for in it."""
    length = b.arclength - a.arclength
    x = (arclength - a.arclength) / length
    return (1 + 2 * x) * (1 - x) ** 2, x**2 * (3 - 2 * x), length * x * (1 - x) ** 2, length * x**2 * (x - 1)
