"""Passages: whether a step that changes the sign of det [J; t^T] stayed on its branch or came out on another one."""

from __future__ import annotations

import numpy as np

from phichain.continuation.engine import Engine
from phichain.continuation.events import BranchPoint
from phichain.continuation.met.locate import curve, root
from phichain.continuation.met.singular import loosened
from phichain.continuation.point import Point
from phichain.continuation.problem import Problem

NEIGHBOURHOOD = 1e-5
"""How close to a zero of det [J; t^T], in steps, it is looked at to see whether it vanishes or jumps."""

SOLVED = 1e-12
"""Relative residual of what solves the problem: halfway across a gap of half width w it is about w^2, small but no round-off, down to
half widths of some 1e-6."""


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
    width = NEIGHBOURHOOD * (b.arclength - a.arclength)
    loose = loosened(engine)
    zero = root(problem, a, b, test, loose, 0.1 * width / (1 + b.arclength)).arclength
    between = curve(problem, a, b, loose)
    sides = [between(float(np.clip(zero + d, a.arclength, b.arclength))) for d in (-width, width)]
    small = 5 * NEIGHBOURHOOD * max(abs(end) for end in ends)
    return all(side.residual < SOLVED and abs(test.value(problem, side)) <= small for side in sides)
