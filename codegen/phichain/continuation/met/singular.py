"""A curve near a point at which [J; t] is singular, where Newton has no digits left: a polynomial through its neighbours.

The curve is analytic through a branch point; planes across it at distances of some 1e-3 on both sides are met to the last digits,
and the polynomial of degree seven through eight of them is right to 1e-13 between. Every test function is smooth along it, its
tangent the polynomial's own: the null vector of J is not one there.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache

import numpy as np
from numpy.polynomial import polynomial

from phichain.continuation.engine import Engine
from phichain.continuation.point import Point
from phichain.continuation.problem import Problem, relative_residual

_SIDES = np.array([-4.0, -3.0, -2.0, -1.0, 1.0, 2.0, 3.0, 4.0]) / 4
_SHARE = 0.2
"""Half the width of the neighbourhood, in lengths of the step that it lies in."""
_WIDEST = 1e-2
"""Largest half width, in arclength."""

Curve = Callable[[float], Point]


@lru_cache
def loosened(engine: Engine) -> Engine:
    """The engine whose Newton takes the plateau of round-off that its corrections end at beside a singular matrix."""
    return replace(engine, options=replace(engine.options, tol=max(engine.options.tol, 1e-8)))


def half_width(a: Point, b: Point) -> float:
    """Half the width of the neighbourhood of a singular point between two points, in arclength."""
    return min(_SHARE * (b.arclength - a.arclength), _WIDEST)


def through(problem: Problem, a: Point, b: Point, centre: float, beside: Curve) -> Curve:
    """The curve between two points, by the polynomial near a singular one and by Newton elsewhere.

    Args:
        problem: What is continued.
        a: Earlier point.
        b: Later point.
        centre: Arclength of the singular point, roughly.
        beside: The curve by Newton.
    """
    half = half_width(a, b)
    places = np.array([beside(centre + half * side).y for side in _SIDES])
    shape = polynomial.polyfit(_SIDES, places, len(_SIDES) - 1)
    slope = polynomial.polyder(shape)

    def between(s: float) -> Point:
        x = (s - centre) / half
        if abs(x) > 1 or s in (a.arclength, b.arclength):
            return beside(s)
        y, along = np.asarray(polynomial.polyval(x, shape)), np.asarray(polynomial.polyval(x, slope))
        residual, jacobian, extra = problem.at(y)
        size = relative_residual(residual, jacobian, y)
        return Point(y, along / np.linalg.norm(along), s, jacobian, size, 0, (), extra)

    return between
