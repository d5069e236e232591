"""A run leg by leg: a method starts anew at every break of the input, and is given a smooth problem in between."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np

from phichain.motion.inputs.purity import Purity
from phichain.motion.ledger import Ledger
from phichain.motion.path import Segment
from phichain.motion.problem import Problem
from phichain.system import Vector

Steps = Callable[[Problem], Iterator[Segment]]


def legwise(problem: Problem, ledger: Ledger, steps: Steps) -> Iterator[Segment]:
    """The segments of all legs, one after the other, each with its input.

    Args:
        problem: What is integrated.
        ledger: Where the legs are noted.
        steps: The method's steps for a problem without breaks.

    Raises:
        ArrayError: A control law gives two answers to one question.
    """
    legs = ledger.legs = problem.legs()
    t, x, t_end = float(problem.t[0]), problem.x0, float(problem.t[-1])
    is_law, count = problem.input is None or problem.input.signal.is_law, 0
    while t != t_end:
        leg = legs.take(t, x)
        if leg.t1 == t:
            continue
        part = problem if problem.input is None else problem.on(leg, _grid(problem, t, leg.t1), x)
        pure = None
        if is_law and leg.held is None:
            count += 1
            pure = Purity(leg.control, t, x, is_copied=count & (count - 1) == 0)  # of a thousand legs ten
        for segment in steps(part):
            if pure is not None:
                pure.look(segment.t1, segment.x1)
            yield segment if segment.control is not None else replace(segment, control=leg.control)
            t, x = segment.t1, segment.x1
        if t != leg.t1:
            return


def _grid(problem: Problem, start: float, stop: float) -> Vector:
    """The outputs within a leg, between its ends; the ends alone where the outputs are the method's own steps."""
    if problem.own_steps:
        return np.array([start, stop])
    inside = problem.t[(problem.t > min(start, stop)) & (problem.t < max(start, stop))]
    return np.concatenate([[start], inside, [stop]])
