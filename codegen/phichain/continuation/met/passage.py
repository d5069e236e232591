"""Passages: whether a step that changes the sign of det [J; t^T] stayed on its branch or came out on another one."""

from __future__ import annotations

import numpy as np

from phichain.continuation.engine import Engine
from phichain.continuation.events import BranchPoint
from phichain.continuation.met.between import curve
from phichain.continuation.met.roots import zero_between
from phichain.continuation.met.singular import loosened
from phichain.continuation.point import Point
from phichain.continuation.problem import Problem

NEIGHBOURHOOD = 1e-5
"""How close to a zero of det [J; t^T], in steps, it is looked at to see whether it vanishes or jumps."""

SOLVED = 1e-12
"""Relative residual of what solves the problem: halfway across a gap of half width w it is about w^2, small but no round-off, down to
half widths of some 1e-6."""

BRACKET = 1e-2
"""Length of a bracket of the zero, in steps, from which on it is looked whether both of its ends stay large."""
_STEEPEST = 20.0
"""How many times as steep as over the whole step the determinant may be there: at a zero both ends shrink with the bracket, at a jump they do not."""


class _JumpedError(Exception):
    """The determinant changes its sign without vanishing."""


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
    step, largest = b.arclength - a.arclength, max(abs(end) for end in ends)
    width, between = NEIGHBOURHOOD * step, curve(problem, a, b, loosened(engine))
    known = {a.arclength: ends[0], b.arclength: ends[1]}

    def of(s: float) -> float:
        known[s] = test.value(problem, between(s))
        low = max(place for place, value in known.items() if value * ends[0] > 0)
        high = min(place for place, value in known.items() if value * ends[0] <= 0)
        if high - low < BRACKET * step and min(abs(known[low]), abs(known[high])) > _STEEPEST * (high - low) / step * largest:
            raise _JumpedError
        return known[s]

    try:
        zero = zero_between(of, a.arclength, b.arclength, ends, 0.1 * width)
    except _JumpedError:
        return False
    sides = [between(float(np.clip(zero + d, a.arclength, b.arclength))) for d in (-width, width)]
    small = 5 * NEIGHBOURHOOD * largest
    return all(side.residual < SOLVED and abs(test.value(problem, side)) <= small for side in sides)
