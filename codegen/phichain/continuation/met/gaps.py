"""Avoided crossings: two branches that come close and turn away from each other, measured by the fit of sigma_min, and crossed on request.

Beside the crossing of two branches that a small term has opened, the smallest singular value of [J; t] goes as

    sigma^2 = a^2 (s - s_0)^2 + w^2,

so that w / a is half the width of the gap in arclength; w = 0 is a branch point. The branch itself turns within that length.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from phichain.continuation.engine import Engine
from phichain.continuation.events import BranchPoint, TestFunction
from phichain.continuation.linear import bordered, sign_of_determinant
from phichain.continuation.met.between import curve
from phichain.continuation.met.locate import locate
from phichain.continuation.met.passage import NARROW
from phichain.continuation.met.specials import Passage, Special
from phichain.continuation.point import Point
from phichain.continuation.problem import Problem

WIDEST = 1e-2
"""Half widths, in arclength, up to which a minimum of sigma is a gap and no more than a bend."""
_CLEAR = (100.0, 30.0, 10.0)
"""Distances, in half widths, at which both branches beside a gap are straight again: the farthest that serves is taken."""
_LEFT = 1e-6
"""What may be left of a test function at its zero, in the larger of its values at both ends."""
_REACH = (2.0, 3.0)
"""How far a leap goes, in distances from the gap."""


def smallest(problem: Problem, point: Point) -> float:
    """The smallest singular value of [J; t]."""
    return abs(BranchPoint().value(problem, point))


def change_sign(near: Sequence[Point]) -> bool:
    """Whether det [J; t] has both signs at some points: a branch point lies between, and no gap."""
    signs = {sign_of_determinant(bordered(point.jacobian, point.tangent)) if not point.sigma else math.copysign(1.0, point.sigma) for point in near}
    return len(signs) > 1


def turned_at(problem: Problem, near: Sequence[Point], sigma: Sequence[float], engine: Engine) -> Passage | None:
    """The gap that a branch turned away from at the middle one of the last three points, which have these sigma; None where there is none."""
    if len(near) < 3 or not sigma[-3] > sigma[-2] <= sigma[-1] or change_sign(near):
        return None
    return gap_between(problem, near, engine)


def gap_between(problem: Problem, near: Sequence[Point], engine: Engine) -> Passage | None:
    """The gap that a branch turned away from at the middle one of three successive points; None where there is none.

    Args:
        problem: What is continued.
        near: Three points.
        engine: Corrector and options.
    """
    low, high = near[0].arclength, near[-1].arclength
    fitted = _fit([point.arclength for point in near], [smallest(problem, point) for point in near])
    if fitted is None or fitted[1] > WIDEST:
        return None
    for _ in range(3):
        centre = float(np.clip(fitted[0], low, high))
        places = [centre - 0.5 * fitted[1], centre, centre + 0.5 * fitted[1]]
        points = [_on(problem, near, s, engine) for s in places]
        try:
            better = _fit(places, [smallest(problem, point) for point in points])
        except np.linalg.LinAlgError:  # beyond where there are orbits at all a Jacobian is no numbers
            return None
        if better is None:
            return None
        fitted = better
    at = _on(problem, near, float(np.clip(fitted[0], low, high)), engine)
    return Passage(at.z(problem), at.arclength, fitted[1], False)


def gap_ahead(problem: Problem, near: Sequence[Point], sigma: Sequence[float]) -> Passage | None:
    """The gap that a run has come so close to that its steps got too small, by the sigma of its last three points; None where there is none.

    Args:
        problem: What is continued.
        near: The points.
        sigma: The smallest singular value of [J; t] at each.
    """
    fitted = _fit([point.arclength for point in near], sigma) if len(near) == 3 else None
    return None if fitted is None else Passage(near[-1].z(problem), fitted[0], fitted[1], False)


def _on(problem: Problem, near: Sequence[Point], s: float, engine: Engine) -> Point:
    before, middle, after = near
    a, b = (before, middle) if s < middle.arclength else (middle, after)
    return curve(problem, a, b, engine)(s)


def _fit(places: Sequence[float], sigma: Sequence[float]) -> tuple[float, float] | None:
    """Centre and half width w / a of the parabola sigma^2 through three places; None where it has no minimum above zero, or a sigma is none."""
    if not all(map(math.isfinite, sigma)):
        return None
    (first, middle, last), (before, at, after) = places, (value * value for value in sigma)
    rising, falling = (after - at) / (last - middle), (at - before) / (middle - first)
    bend = (rising - falling) / (last - first)
    slope = falling + bend * (middle - first)
    if bend <= 0 or at - slope**2 / (4 * bend) <= 0:
        return None
    return middle - slope / (2 * bend), math.sqrt((at - slope**2 / (4 * bend)) / bend)


def across(problem: Problem, points: Sequence[Point], gap: Passage, engine: Engine) -> tuple[int, Point] | None:
    """The first point of the branch that goes on straight beyond a gap, and the index of the last one before it.

    Args:
        problem: What is continued.
        points: The points so far.
        gap: The gap, behind which the last of them lie.
        engine: Corrector and options.

    Returns:
        None where Newton reaches nothing on the other side.
    """
    for distance in _CLEAR:
        before = [k for k, point in enumerate(points) if point.arclength < gap.arclength - distance * gap.width]
        for reach in _REACH if before else ():
            last = points[before[-1]]
            guess = last.y + reach * (gap.arclength - last.arclength) * last.tangent
            found = engine.corrector(problem, guess, last.tangent, engine.options)
            if not found.converged:
                continue
            new = found.point(last.tangent, last.arclength + float(np.linalg.norm(found.y - last.y)))
            if new.tangent @ last.tangent > np.cos(engine.options.max_angle) and change_sign((last, new)):
                return before[-1], new
    return None


def met_across(
    problem: Problem, a: Point, b: Point, gap: Passage, tests: Sequence[TestFunction], engine: Engine, index: int
) -> tuple[list[Special], Point | None]:
    """The events on the way straight across a gap, as `locate` finds them on a branch.

    A gap that counts as a branch point is one; of what jumps with the branches nothing vanishes in between.

    Args:
        problem: What is continued.
        a: The last point before the gap.
        b: The first one beyond.
        gap: The gap.
        tests: Test functions.
        engine: Corrector and options.
        index: Index of `a` in its branch.

    Returns:
        The events in order, none after a terminal one; and the point of that, or None.
    """
    kept = [test for test in tests if gap.width <= NARROW or not isinstance(test, BranchPoint)]
    found, cut = locate(problem, a, b, kept, engine, index)
    largest = {test.name: max(abs(test.value(problem, end)) for end in (a, b)) for test in kept}
    return [event for event in found if abs(event.value) <= _LEFT * largest[event.kind] or (cut is not None and event is found[-1])], cut
