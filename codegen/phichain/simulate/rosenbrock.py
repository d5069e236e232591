"""The emitted implicit flow: an L-stable Rosenbrock method of order 5 (Rodas5P, Steinebach 2023), for stiff chains.

``path`` runs a whole problem in compiled code when nothing has to be watched step by step; ``segments`` gives the steps
one by one, for events that are Python functions and for outputs at the method's own steps. A state inside a step is the end
of a shorter step from the same start, so it has the method's own order.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from phichain.errors import UnsupportedError
from phichain.propagation import StiffPropagation
from phichain.simulate.path import Path, Segment, StalledError, StateAt
from phichain.simulate.problem import Problem
from phichain.system import Vector, pack, unpack

#: Pieces into which a long run is cut to report progress.
_PIECES = 100


def is_possible(problem: Problem) -> bool:
    """Whether the system has the flow and its input, if any, is constant."""
    return problem.system.has("propagate_stiff") and (problem.control is None or problem.held is not None)


def segments(problem: Problem, name: str) -> Iterator[Segment]:
    """The flow's steps, one by one.

    Raises:
        UnsupportedError: the input is a function, or the system has no flow.
        StalledError: no step, however short, led to finite numbers within the tolerance.
    """
    run = _Run(problem, name)
    t_end = float(problem.t[-1])
    t, x = float(problem.t[0]), problem.x0
    refused = 0
    while t != t_end:
        start = run.carried
        step = run(t, x, t_end, max_steps=1)
        if step.outcome == "not finite":
            raise StalledError(f"{name} left the finite numbers")
        refused += step.refused
        problem.counts.update(refused=refused, order=step.order)
        if not step.steps:
            continue
        after = pack(step.q, step.v)
        problem.counts["steps"] = problem.counts.get("steps", 0) + 1
        yield Segment(t, step.t, after, _inside(run, t, x, start))
        t, x = step.t, after


def path(problem: Problem, name: str) -> Path:
    """The states at the problem's times, in compiled code from end to end.

    Raises:
        UnsupportedError: the input is a function, or the system has no flow.
    """
    run = _Run(problem, name)
    grid = problem.t
    t, x, steps, refused = float(grid[0]), problem.x0, 0, 0
    times, states = [t], [x]
    status, message = "complete", ""
    for piece in np.array_split(grid[1:], min(len(grid) - 1, _PIECES)):
        left = problem.max_steps - steps - refused
        found = run(t, x, float(piece[-1]), max_steps=left, times=piece)
        t, x, steps, refused = found.t, pack(found.q, found.v), steps + found.steps, refused + found.refused
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
    problem.counts.update(steps=steps, refused=refused, order=run.order)
    return Path(np.array(times), np.array(states), status, message, (), steps, None)


class _Run:
    """The system's flow with everything bound that does not change on the way, and what it carries from call to call."""

    def __init__(self, problem: Problem, name: str) -> None:
        self.system, self.tol, self.order = problem.system, problem.tol, 0
        self.propagate = problem.system.function("propagate_stiff")
        if not is_possible(problem):
            raise UnsupportedError(
                "u", problem.control, f"{name} holds its input constant", "use Radau, or a constant u"
            )
        self.fixed: dict[str, Any] = dict(problem.system.parameters(problem.p))
        if problem.held is not None:
            self.fixed["u"] = problem.held
        self.carried: dict[str, Any] = {}

    def __call__(self, t: float, x: Vector, t_end: float, **options: Any) -> StiffPropagation:
        found = self.once(t, x, t_end, **self.carried, **options)
        self.carried = {"lost": found.lost, "memory": found.memory}
        self.order = found.order
        return found

    def once(self, t: float, x: Vector, t_end: float, **options: Any) -> StiffPropagation:
        """One call that leaves nothing behind."""
        q, v = unpack(self.system, x)
        found: StiffPropagation = self.propagate(q, v, t, t_end, self.tol, **options, **self.fixed)
        return found


def _inside(run: _Run, t0: float, x0: Vector, start: dict[str, Any]) -> Any:
    def at(t: float) -> Vector:
        # A step that ends there: shorter than the one that was taken, so within the tolerance as well.
        found = run.once(t0, x0, t, **(start | {"memory": (t - t0, 0.0)}))
        return pack(found.q, found.v)

    def dense() -> StateAt:
        return at

    return dense


def _early(found: StiffPropagation, problem: Problem, name: str) -> tuple[str, str]:
    t_end = float(problem.t[-1])
    if found.outcome == "step budget":
        return (
            "step budget",
            f"{problem.max_steps} steps, the budget, brought it to t = {found.t:.6g} s of {t_end:.6g} s",
        )
    size = float(max(np.max(np.abs(found.q)), np.max(np.abs(found.v))))
    return "blow-up", f"{name} left the finite numbers at t = {found.t:.6g} s (largest entry {size:.3g})"
