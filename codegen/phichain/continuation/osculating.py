"""The polynomial that touches a curve at several of its points, over the distance along a direction.

Over the distance sigma = axis . y the curve is a function where it does not turn away from the axis, with values y_k and slopes
t_k / (axis . t_k) that are known to the last digit: no length of an arc has to be summed up, and Hermite's polynomial through m points
is right to the order 2 m.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from phichain.continuation.point import Point
from phichain.continuation.problem import Problem
from phichain.system import Vector

_TURNED = 0.5
"""Cosine of tangent and axis below which a point is too far round a bend to say anything."""
_APART = 0.1
"""Distance of two points, in that from the place, below which the farther one adds nothing but rounding."""


def osculating(near: Sequence[Point], axis: Vector, place: float) -> Vector | None:
    """Where the curve through some points has the distance `place` along a direction; the points that turned away from it are left out.

    Args:
        near: Points of the curve, in order.
        axis: Unit vector (n + 1,), in scaled unknowns.
        place: axis . y that is wanted.

    Returns:
        y there (n + 1,), its own distance `place` but for rounding; None where no point goes along the axis.
    """
    known = np.array([(point.y, point.tangent) for point in near])
    rises = [(abs(own - place), own, along, k) for k, (own, along) in enumerate((known @ axis).tolist()) if along > _TURNED]
    rises.sort()
    kept: list[tuple[float, float, int]] = []
    for far, own, along, k in rises:
        for other, _, _ in kept:
            if abs(own - other) <= _APART * far:
                break
        else:
            kept.append((own, along, k))
    if not kept:
        return None
    weights = np.zeros((len(near), 2))
    for own, along, k in kept:
        lagrange, bend, off = 1.0, 0.0, place - own
        for other, _, j in kept:
            if j != k:
                apart = own - other
                lagrange *= (place - other) / apart
                bend += 1 / apart
        # Hermite's form: Lagrange's polynomial, squared, times what makes value or slope 1 at the place.
        square = lagrange * lagrange
        weights[k] = (1 - 2 * off * bend) * square, off * square / along
    there: Vector = weights.ravel() @ known.reshape(-1, len(axis))
    return there


def touched(problem: Problem, near: Sequence[Point], axis: Vector, place: float) -> Vector | None:
    """The same of points of a problem's curve, in C where that is compiled."""
    if problem.compiled is None:
        return osculating(near, axis, place)
    return problem.compiled.touched([(point.y, point.tangent) for point in near], axis, place)
