"""The emitted Taylor flow, order and steps chosen from the tolerance (Jorba and Zou 2005).

``path`` runs a whole problem in compiled code when nothing has to be watched step by step; ``segments`` gives the steps
one by one, for events that are Python functions and for outputs at the method's own steps. Both carry the flow's
compensation from call to call, so that cutting a run into pieces costs no digits.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from phichain.errors import UnsupportedError
from phichain.propagation import Propagation
from phichain.simulate.path import Path, Segment, StalledError, StateAt
from phichain.simulate.problem import Problem
from phichain.system import Vector, pack, unpack

#: Pieces into which a long run is cut to report progress.
_PIECES = 100


def is_possible(problem: Problem) -> bool:
    """Whether the system has the flow and its input, if any, is constant."""
    return problem.system.has("propagate") and (problem.control is None or problem.held is not None)


def runs_whole(problem: Problem) -> bool:
    """Whether `path` serves: outputs at given times, nothing watched."""
    return not problem.events and not problem.own_steps


def segments(problem: Problem, name: str) -> Iterator[Segment]:
    """The flow's steps, one call each; a state within one is the flow's own series.

    Raises:
        UnsupportedError: the input is a function, or the system has no flow.
        StalledError: the state or its series stopped being finite.
    """
    run = _Run(problem, name)
    t_end = float(problem.t[-1])
    t, x, lost = float(problem.t[0]), problem.x0, None
    while t != t_end:
        step = run(t, x, t_end, lost, max_steps=1)
        if step.outcome == "not finite":
            raise StalledError(f"{name} left the finite numbers")
        after = pack(step.q, step.v)
        yield Segment(t, step.t, after, _inside(run, t, x, step.t, lost))
        t, x, lost = step.t, after, step.lost


def path(problem: Problem, name: str) -> Path:
    """The states at the problem's times, in compiled code from end to end.

    Raises:
        UnsupportedError: the input is a function, or the system has no flow.
    """
    run = _Run(problem, name)
    grid = problem.t
    t, x, lost, steps = float(grid[0]), problem.x0, None, 0
    times, states = [t], [x]
    status, message = "complete", ""
    for piece in np.array_split(grid[1:], min(len(grid) - 1, _PIECES)):
        found = run(t, x, float(piece[-1]), lost, max_steps=problem.max_steps - steps, times=piece)
        t, x, lost, steps = found.t, pack(found.q, found.v), found.lost, steps + found.steps
        times += piece[: len(found.q_at)].tolist()
        states += list(pack(found.q_at, found.v_at))
        if problem.progress is not None:
            problem.progress((t - float(grid[0])) / float(grid[-1] - grid[0]), t)
        if found.outcome != "done":
            status, message = _early(found, problem, name)
            break
    if times[-1] != t:
        times.append(t)
        states.append(x)
    problem.counts.update(steps=steps, order=run.order)
    return Path(np.array(times), np.array(states), status, message, (), steps, None)


class _Run:
    """The system's flow with everything bound that does not change on the way."""

    def __init__(self, problem: Problem, name: str) -> None:
        self.system, self.tol, self.order = problem.system, problem.tol, 0
        self.propagate = problem.system.function("propagate")
        if not is_possible(problem):
            raise UnsupportedError(
                "u", problem.control, f"{name} holds its input constant", "use DOP853, or a constant u"
            )
        self.fixed: dict[str, Any] = dict(problem.system.parameters(problem.p))
        if problem.held is not None:
            self.fixed["u"] = problem.held

    def __call__(self, t: float, x: Vector, t_end: float, lost: Vector | None, **options: Any) -> Propagation:
        q, v = unpack(self.system, x)
        found: Propagation = self.propagate(q, v, t, t_end, self.tol, lost=lost, **options, **self.fixed)
        self.order = found.order
        return found


def _inside(run: _Run, t0: float, x0: Vector, t1: float, lost: Vector | None) -> Any:
    def at(t: float) -> Vector:
        # From the same state the same series: one step of the flow that is asked for a state on its way.
        found = run(t0, x0, t1, lost, max_steps=1, times=[t])
        return pack(found.q_at[0], found.v_at[0])

    def dense() -> StateAt:
        return at

    return dense


def _early(found: Propagation, problem: Problem, name: str) -> tuple[str, str]:
    t_end = float(problem.t[-1])
    if found.outcome == "step budget":
        return "step budget", f"{problem.max_steps} steps, the budget, brought it to t = {found.t:.6g} s of {t_end:.6g} s"
    size = float(max(np.max(np.abs(found.q)), np.max(np.abs(found.v))))
    return "blow-up", f"{name} left the finite numbers at t = {found.t:.6g} s (largest entry {size:.3g})"
