"""A curve near a point at which [J; t] is singular, where Newton has no digits left: a polynomial through its neighbours.

The curve is analytic through a branch point; planes across it at distances of some 1e-3 on both sides are met to the last digits,
and the polynomial of degree seven through eight of them is right to 1e-13 between; where the curve bends so soon that those of lower degrees say
otherwise, which a long step need not have felt, through nearer ones. Every test function is smooth along it, its
tangent the polynomial's own: the null vector of J is not one there.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from itertools import pairwise

import numpy as np
from numpy.polynomial import polynomial

from phichain.continuation.engine import Engine
from phichain.continuation.events import TestFunction
from phichain.continuation.met.between import Between
from phichain.continuation.point import Point
from phichain.continuation.problem import Problem, relative_residual
from phichain.system import Vector

_SIDES = np.array([-4.0, -3.0, -2.0, -1.0, 1.0, 2.0, 3.0, 4.0]) / 4
_INNER = float(np.min(np.abs(_SIDES)))
_SHARE = 0.2
"""Half the width of the neighbourhood, in lengths of the step that it lies in."""
_WIDEST = 1e-2
"""Largest half width, in arclength."""
_NARROWEST = 2e-4
"""Smallest one, likewise: below it Newton's round-off is more than the polynomial's error."""
_FITS = [np.asarray(np.linalg.inv(polynomial.polyvander(_SIDES[k : 8 - k], 7 - 2 * k)), float) for k in range(3)]
"""Coefficients of the polynomials through all places, through all but the outermost, and through the inner four: times what they have there."""
_RESOLVED = 1e-11
"""Error of the polynomial in the middle that is none, in units of 1 + |y|."""


@lru_cache
def loosened(engine: Engine) -> Engine:
    """The engine whose Newton takes the plateau of round-off that its corrections end at beside a singular matrix."""
    return replace(engine, options=replace(engine.options, tol=max(engine.options.tol, 1e-8)))


def half_width(a: Point, b: Point) -> float:
    """Half the width of the neighbourhood of a singular point between two points, in arclength."""
    return min(_SHARE * (b.arclength - a.arclength), _WIDEST)


class Through:
    """The curve between two points, by the polynomial near a singular one and by Newton elsewhere.

    Attributes:
        a: One end.
        b: The other.
        is_resolved: Whether the polynomial is known to be the curve to round-off.
    """

    def __init__(self, problem: Problem, centre: float, beside: Between) -> None:
        """Take the arclength of the singular point, roughly, and the curve by Newton."""
        self.a, self.b, self._problem, self._beside, self._centre = beside.a, beside.b, problem, beside, centre
        self._half = half_width(self.a, self.b)
        places = beside.places(centre + self._half * _SIDES)
        self.is_resolved = self._half >= _NARROWEST and _is_resolved(places)
        while self._half > _NARROWEST and not self.is_resolved:
            self._half /= 2
            places = beside.places(centre + self._half * _SIDES)
            self.is_resolved = _is_resolved(places)
        self._shape: Vector = _FITS[0] @ places
        self._slope = polynomial.polyder(self._shape)

    def is_inside(self, s: float) -> bool:
        """Whether an arclength lies between the places that the polynomial goes through, on either side of it."""
        return bool(abs(s - self._centre) < _INNER * self._half)

    def __call__(self, s: float) -> Point:
        """The point at an arclength."""
        x, problem = (s - self._centre) / self._half, self._problem
        if abs(x) > 1 or s in (self.a.arclength, self.b.arclength):
            return self._beside(s)
        y, along = np.asarray(polynomial.polyval(x, self._shape)), np.asarray(polynomial.polyval(x, self._slope))
        residual, jacobian, extra = problem.at(y)
        size = relative_residual(residual, jacobian, y)
        return Point(y, along / np.linalg.norm(along), s, jacobian, size, 0, (), extra)

    def zero(
        self, test: TestFunction, values: tuple[float, float], near: tuple[float, float, bool], beyond: Sequence[tuple[float, float]]
    ) -> tuple[tuple[Point, float], tuple[Point, float], float] | None:
        """As `Between.zero`."""
        return self._beside.zero(test, values, near, beyond, (self._centre, self._half, self._shape))


def _is_resolved(places: Vector) -> bool:
    """Whether the polynomials through more and more of the places converge in the middle, place and slope."""
    fits = [fit[:2] @ places[k : 8 - k] for k, fit in enumerate(_FITS)]
    last, before = (float(np.max(np.abs(one - other))) for one, other in pairwise(fits))
    # Errors that fall as they did before: by the same factor once more.
    return last * min(1.0, last / before if before else 1.0) <= _RESOLVED * (1 + float(np.max(np.abs(places))))
