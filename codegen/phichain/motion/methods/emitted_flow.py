"""What the emitted flows, the Taylor flow and the implicit one, share: a whole run in compiled code, step after step.

A flow goes on where it stopped with what it carries from call to call (what rounding took, the size of the next step), so
that cutting a run into pieces costs no digits.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any, Final, Generic, TypeVar

import numpy as np

from phichain.errors import UnsupportedError
from phichain.motion.path import Path, StateAt, tell
from phichain.motion.problem import Problem
from phichain.system import Vector, pack
from phichain.system.propagation import Propagation

P = TypeVar("P", bound=Propagation)

#: Steps after which a watched run comes back to report progress.
_REPORTED: Final = 1000


def is_possible(problem: Problem, function: str) -> bool:
    """Whether the system has the flow and its input, if any, is constant."""
    return problem.system.has(function) and (problem.control is None or problem.held is not None)


class EmittedFlow(Generic[P]):
    """A system's flow with everything bound that does not change on the way, and what it carries from call to call."""

    def __init__(
        self, problem: Problem, name: str, function: str, instead: str, carry: Callable[[P], dict[str, Any]]
    ) -> None:
        """Bind the flow to a problem.

        Args:
            problem: What is to be integrated.
            name: The method's name, for messages.
            function: The flow's name in the contract.
            instead: The method for inputs that move.
            carry: What of a result the next call goes on with.

        Raises:
            UnsupportedError: the input is a function, or the system has no flow.
        """
        self.system, self.tol, self.order, self.name = problem.system, problem.tol, 0, name
        self.propagate = problem.system.function(function)
        if not is_possible(problem, function):
            raise UnsupportedError(
                "u", problem.control, f"{name} holds its input constant", f"use {instead}, or a constant u"
            )
        self.fixed: dict[str, Any] = dict(problem.system.parameters(problem.p))
        if problem.held is not None:
            self.fixed["u"] = problem.held
        self.carry = carry
        self.carried: dict[str, Any] = {}

    def __call__(self, t: float, x: Vector, t_end: float, **options: Any) -> P:
        found = self.once(t, x, t_end, **self.carried, **options)
        self.carried = self.carry(found)
        self.order = found.order
        return found

    def once(self, t: float, x: Vector, t_end: float, **options: Any) -> P:
        """One call that leaves nothing behind."""
        nq = self.system.nq
        found: P = self.propagate(x[:nq], x[nq:], t, t_end, self.tol, **options, **self.fixed)
        return found


def whole_path(problem: Problem, run: EmittedFlow[P]) -> tuple[Path, int]:
    """The states at the problem's times, in compiled code from end to end, and how many steps were refused on the way."""
    grid, t_end = problem.t, float(problem.t[-1])
    t, x, steps, tried, told = float(grid[0]), problem.x0, 0, 0, 0.0
    times, states = [t], [x]
    status, message = "complete", ""
    while True:
        left = problem.max_steps - tried
        most = left if problem.progress is None else min(left, _REPORTED)
        found = run(t, x, t_end, max_steps=most, times=grid[len(times) :])
        t, x, steps, tried = found.t, pack(found.q, found.v), steps + found.steps, tried + found.tried
        times += grid[len(times) : len(times) + len(found.q_at)].tolist()
        states += list(pack(found.q_at, found.v_at))
        told = tell(problem, t, told)
        if found.outcome == "done":
            break
        if found.outcome != "step budget" or tried >= problem.max_steps:
            status, message = _early(found, problem, run.name)
            break
    if times[-1] != t:
        times.append(t)
        states.append(x)
    return Path(np.array(times), np.array(states), status, message, (), steps, None), tried - steps


def own_path(problem: Problem, run: EmittedFlow[P]) -> Path:
    """The states at the ends of the flow's own steps, in compiled code from end to end."""
    t0, t_end = float(problem.t[0]), float(problem.t[-1])
    t, x, steps, told = t0, problem.x0, 0, 0.0
    pieces: list[P] = []
    status, message = "complete", ""
    while True:
        left = problem.max_steps - steps
        found = run(t, x, t_end, max_steps=left if problem.progress is None else min(left, _REPORTED), own=True)
        t, x, steps = found.t, np.concatenate((found.q, found.v)), steps + found.steps
        pieces.append(found)
        told = tell(problem, t, told)
        if found.outcome == "done":
            break
        if found.outcome != "step budget" or steps >= problem.max_steps:
            status, message = _early(found, problem, run.name)
            break
    again = partial(_again, problem, run, t, x, steps)
    return Path(*_strung(t0, problem.x0, pieces), status, message, (), steps, again)


def _strung(t0: float, x0: Vector, pieces: list[P]) -> tuple[Vector, Vector]:
    """Times and states of a start and of all that was passed after it."""
    count, nq = 1 + sum(len(piece.t_at) for piece in pieces), pieces[0].q_at.shape[1]
    times, states, at = np.empty(count), np.empty((count, len(x0))), 1
    times[0], states[0] = t0, x0
    for piece in pieces:
        end = at + len(piece.t_at)
        times[at:end], states[at:end, :nq], states[at:end, nq:] = piece.t_at, piece.q_at, piece.v_at
        at = end
    return times, states


def _again(problem: Problem, run: EmittedFlow[P], t_last: float, x_last: Vector, steps: int, times: Vector) -> Vector:
    """The states at other times of a run that ended at `t_last` in `x_last`: from the same start the same series."""
    t0, t_end = float(problem.t[0]), float(problem.t[-1])
    order = np.argsort(times if t_end >= t0 else -times, kind="stable")
    inside = order[times[order] != t_last]
    states = np.tile(x_last, (len(times), 1))
    if inside.size:
        # The run may have been cut into calls, which changes its last bits: one step more than it took is enough for all.
        found = run.once(t0, problem.x0, t_end, times=times[inside], max_steps=steps + 1)
        states[inside[: len(found.q_at)]] = np.concatenate((found.q_at, found.v_at), axis=1)
    return states


def dense(at: StateAt) -> Callable[[], StateAt]:
    """A segment's states in between, which nothing has to be prepared for."""
    return lambda: at


def _early(found: Propagation, problem: Problem, name: str) -> tuple[str, str]:
    t_end = float(problem.t[-1])
    if found.outcome == "step budget":
        return "step budget", f"{problem.max_steps} steps, the budget, brought it to t = {found.t:.6g} s of {t_end:.6g} s"
    size = float(max(np.max(np.abs(found.q)), np.max(np.abs(found.v))))
    return "blow-up", f"{name} left the finite numbers at t = {found.t:.6g} s (largest entry {size:.3g})"
