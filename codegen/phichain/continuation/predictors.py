"""Predictors: a guess for the next point. A predictor is any callable `(points, step) -> guess`.

`points` are the points so far, newest last; guesses are in scaled unknowns.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from phichain.continuation.point import Point
from phichain.system import Vector

Predictor = Callable[[Sequence[Point], float], Vector]


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


def quintic(points: Sequence[Point], step: float) -> Vector:
    """Along the quintic through the last three points and their tangents; error of sixth order in the step.

    Arclength is summed up from chords; between points it is taken as long as circles with their tangents are, which is right to
    the fifth order.
    """
    if len(points) < 3:
        return cubic(points, step)
    last = _arc(points[-2], points[-1])
    places = (-_arc(points[-3], points[-2]) - last, -last, 0.0)
    weights, slopes = [], []
    for k, place in enumerate(places):
        others = places[:k] + places[k + 1 :]
        # Hermite's form: Lagrange's polynomial of the place, squared, times what makes value or slope 1 there.
        lagrange = math.prod((step - other) / (place - other) for other in others)
        bend = sum(1 / (place - other) for other in others)
        weights.append((1 - 2 * (step - place) * bend) * lagrange**2)
        slopes.append((step - place) * lagrange**2)
    near = points[-3:]
    return np.array(weights + slopes) @ np.array([point.y for point in near] + [point.tangent for point in near])


def _arc(a: Point, b: Point) -> float:
    """Length of the circle's arc between two points with their tangents."""
    bend = b.tangent - a.tangent
    return (b.arclength - a.arclength) * (1 + float(bend @ bend) / 24)


def hermite(a: Point, b: Point, arclength: float) -> Vector:
    """Value at `arclength` of the cubic with the places and tangents of two points."""
    length = b.arclength - a.arclength
    x = (arclength - a.arclength) / length
    return (
        (1 + 2 * x) * (1 - x) ** 2 * a.y
        + x**2 * (3 - 2 * x) * b.y
        + length * x * (1 - x) ** 2 * a.tangent
        + length * x**2 * (x - 1) * b.tangent
    )
