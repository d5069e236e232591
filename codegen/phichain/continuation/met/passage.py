"""Passages: whether a step that changes the sign of det [J; t^T] stayed on its branch or came out on another one."""

from __future__ import annotations

import math

from phichain.continuation.engine import Engine
from phichain.continuation.events import BranchPoint
from phichain.continuation.met.between import curve
from phichain.continuation.met.roots import zero_between
from phichain.continuation.met.singular import loosened
from phichain.continuation.point import Point
from phichain.continuation.problem import Problem

NARROW = 3e-6
"""Half width of a gap, in arclength, below which it counts as a branch point, whatever the step: beside a narrower one Newton has too few digits left."""
SOLVED = 1e-12
"""Relative residual of what solves the problem: halfway across a gap of half width w it is about w^2, small but no round-off, down to
half widths of some 1e-6."""
_BRACKET = 1e-2
"""Length of a bracket of the zero, in steps, from which on it is looked whether its ends come down to zero."""
_RISE = 1.5
"""How far up both ends may go again while the bracket gets shorter: at a zero they come down, at a jump they part."""
TURNED = math.sqrt(0.5)
"""Cosine of the turn of a branch beside a gap at its half width from the middle."""
_NEAREST = 0.1
"""How close to the zero it is looked at, in steps, where these are short."""


class _JumpedError(Exception):
    """The determinant changes its sign without vanishing."""


def is_crossed_smoothly(problem: Problem, a: Point, b: Point, engine: Engine) -> bool:
    """False when det [J; t^T] has another sign at `b` than at `a` without vanishing: b is on another branch.

    At a branch point the determinant crosses zero linearly and the curve goes on: close to the zero, on both sides, the corrector converges
    and finds values that go as the distance. Where a step jumped across a gap of half width w, the planes between the branches meet either one
    where u v = w^2, so that at a distance u from the middle the smallest singular value goes as the root of u^2 + w^4 / u^2: two places at u and 2 u
    tell w, how steep the value is, and how far it reaches before another one is smaller, being no matter; at u = w the branch has turned by half a
    right angle. Farther jumps meet neither branch nearby.
    """
    test = BranchPoint()
    ends = test.value(problem, a), test.value(problem, b)
    if ends[0] * ends[1] >= 0:
        return True
    step = b.arclength - a.arclength
    width, between = min(NARROW, _NEAREST * step), curve(problem, a, b, loosened(engine))
    known = {a.arclength: ends[0], b.arclength: ends[1]}
    least = math.inf

    def of(s: float) -> float:
        nonlocal least
        known[s] = test.value(problem, between(s))
        low = max(place for place, value in known.items() if value * ends[0] > 0)
        high = min(place for place, value in known.items() if value * ends[0] <= 0)
        if high - low < _BRACKET * step:
            both = abs(known[low]) + abs(known[high])
            if both > _RISE * least:
                raise _JumpedError
            least = min(least, both)
        return known[s]

    try:
        zero = zero_between(of, a.arclength, b.arclength, ends, 0.1 * width)
    except _JumpedError:
        return False
    # What was met on the way to the zero is far from it, and near enough if the value goes as the distance up to there.
    beyond = min((place for place in known if abs(place - zero) >= 2 * width), key=lambda place: abs(place - zero))
    reference = abs(beyond - zero) / width, known[beyond]

    def value(s: float) -> float:
        """The test function; none where the branch is not met, or turns away as it does where a gap is as wide as `width`."""
        point = between(min(max(s, a.arclength), b.arclength))
        is_met = point.residual < SOLVED and point.tangent @ a.tangent >= TURNED
        return test.value(problem, point) if is_met else math.nan

    for side in (-width, width):
        near = value(zero + side)
        if not (_vanishes(near, *reference) or _vanishes(near, 2.0, value(zero + 2 * side))):
            return False
    return True


def _vanishes(near: float, distance: float, far: float) -> bool:
    """Whether a value at a distance of 1, and another one farther away, leave no gap whose half width is 1 or more; not where one is none."""
    return 2 * far**2 >= near**2 * (distance**2 + 1 / distance**2)
