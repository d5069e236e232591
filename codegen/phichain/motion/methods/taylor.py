"""The emitted Taylor flow, order and steps chosen from the tolerance (Jorba and Zou 2005).

``path`` runs a whole problem in compiled code when nothing has to be watched step by step; ``segments`` gives the steps
one by one, for events that are Python functions.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from phichain.motion.balance import MANY
from phichain.motion.ledger import Ledger
from phichain.motion.methods import emitted_flow
from phichain.motion.methods.emitted_flow import EmittedFlow
from phichain.motion.methods.legwise import legwise
from phichain.motion.path import Path, Segment, StalledError, StateAt, StatesAt
from phichain.motion.problem import Problem
from phichain.system import Vector, pack
from phichain.system.propagation import Propagation


def is_possible(problem: Problem) -> bool:
    """Whether the system has the flow and its input, if any, is constant between breaks that are known."""
    return emitted_flow.is_possible(problem, "propagate")


def segments(problem: Problem, name: str, ledger: Ledger) -> Iterator[Segment]:
    """The flow's steps, one call each; states within one are the flow's own series.

    Raises:
        UnsupportedError: the input is a function, or the system has no flow.
        StalledError: the state or its series stopped being finite.
    """
    run = _run(problem, name)
    yield from legwise(problem, ledger, lambda part: _steps(part, run))


def _steps(problem: Problem, run: EmittedFlow[Propagation]) -> Iterator[Segment]:
    run.hold(problem.held)
    t_end = float(problem.t[-1])
    t, x = float(problem.t[0]), problem.x0
    while t != t_end:
        start = run.options
        step = run(t, x, t_end, max_steps=1)
        if step.outcome == "not finite":
            raise StalledError(f"{run.name} left the finite numbers")
        after, t1 = pack(step.q, step.v), emitted_flow.reached(step, t_end)
        looks = _looks(run, t, x, t1, start)
        yield Segment(t, t1, after, emitted_flow.dense(_one_of(looks)), looks=looks, points=MANY)
        t, x = t1, after


def path(problem: Problem, name: str, ledger: Ledger) -> Path:
    """The states at the problem's times, or at the ends of its own steps, in compiled code from end to end.

    Raises:
        UnsupportedError: the input is a function, or the system has no flow.
    """
    run = _run(problem, name)
    if ledger.is_watched and not problem.is_moved:
        run.watch()
    found, _ = (emitted_flow.own_path if problem.own_steps else emitted_flow.whole_path)(problem, run, ledger)
    ledger.counts.update(steps=found.steps, order=run.order)
    return found


def _run(problem: Problem, name: str) -> EmittedFlow[Propagation]:
    return EmittedFlow(problem, name, "propagate", "DOP853", lambda found: {"lost": found.lost})


def _looks(run: EmittedFlow[Propagation], t0: float, x0: Vector, t1: float, start: dict[str, Any]) -> StatesAt:
    def at(times: Vector) -> Vector:
        # From the same state the same series: one step of the flow that is asked for states on its way.
        found = run.once(t0, x0, t1, **start, max_steps=1, times=times)
        return pack(found.q_at, found.v_at)

    return at


def _one_of(looks: StatesAt) -> StateAt:
    return lambda t: looks(np.array([t]))[0]
