"""What the emitted flows, the Taylor flow and the implicit one, share: a whole run in compiled code, step after step.

A flow goes on where it stopped with what it carries from call to call (what rounding took, the size of the next step), so
that cutting a run into pieces costs no digits.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, Final, Generic, TypeVar

import numpy as np

from phichain.errors import UnsupportedError
from phichain.motion.balance import MANY, Account
from phichain.motion.ledger import Ledger
from phichain.motion.path import OFTEN, Path, StateAt, tell
from phichain.motion.problem import Problem
from phichain.records import Held
from phichain.system import Vector
from phichain.system.propagation import Propagation

P = TypeVar("P", bound=Propagation)

#: As good as zero, rad and rad/s, and yet not zero.
SMALLEST: Final = {"double": 1e-300, "float": 1e-30}
#: Steps that are asked once more in one call: a chaotic motion leaves no other one in so few.
_BOOKED: Final = 16


def is_possible(problem: Problem, function: str) -> bool:
    """Whether the system has the flow and its input, if any, is constant between breaks that are known."""
    return problem.system.has(function) and problem.is_held


class EmittedFlow(Generic[P]):
    """A system's flow with everything bound that does not change on the way, and what it carries from call to call."""

    def __init__(
        self, problem: Problem, name: str, function: str, instead: str, carry: Callable[[P], dict[str, Any]],
        points: int = MANY, restart: Callable[[float], dict[str, Any]] = lambda h: {},
    ) -> None:  # fmt: skip
        """Bind the flow to a problem.

        Args:
            problem: What is to be integrated.
            name: The method's name, for messages.
            function: The flow's name in the contract.
            instead: The method for inputs that move.
            carry: What of a result the next call goes on with.
            points: At how many points within a step powers are looked at, as the order of its states needs.
            restart: What a call needs that begins at the start of a step of some length, beside the state there.

        Raises:
            UnsupportedError: the input is a function, or the system has no flow.
        """
        self.system, self.tol, self.order, self.name = problem.system, problem.tol, 0, name
        self.propagate = problem.system.function(function)
        if not is_possible(problem, function):
            raise UnsupportedError(
                "u", problem.control, f"{name} holds its input constant",
                f"use {instead}, a constant u, a held table, or sample=Ts for a law that samples",
            )
        self.fixed: dict[str, Any] = dict(problem.system.parameters(problem.p))
        if problem.held is not None:
            self.fixed["u"] = problem.held
        self.carry, self.points, self.restart = carry, points, restart
        self.carried: dict[str, Any] = {}
        self.along: dict[str, Any] = {}

    def watch(self) -> None:
        """Have the flow leave its steps, where it can, for neighbours to fly beside."""
        make = getattr(self.propagate, "beside", None)
        self.along = {} if make is None else {"beside": make()}

    def __call__(self, t: float, x: Vector, t_end: float, **options: Any) -> P:
        found = self.once(t, x, t_end, **self.carried, **self.along, **options)
        self.carried = self.carry(found)
        self.order = found.order
        return found

    def off(self, count: int) -> Callable[[], Vector] | None:
        """Finds what neighbours say of the errors at the first `count` times of a run, its start included; None where it left no steps."""
        beside = self.along.get("beside")
        return None if beside is None else lambda: np.concatenate((np.zeros((1, 2)), beside.errors))[:count]

    def hold(self, u: Vector | None) -> None:
        """Go on with another input, if the chain has any."""
        if self.system.nu:
            self.fixed["u"] = u

    @property
    def options(self) -> dict[str, Any]:
        """What the next call goes on with, and its input: what makes it the same call again."""
        return self.carried | ({"u": self.fixed["u"]} if "u" in self.fixed else {})

    def once(self, t: float, x: Vector, t_end: float, **options: Any) -> P:
        """One call that leaves nothing behind."""
        nq, given = self.system.nq, {**self.fixed, **options}
        if not x.any() and np.any(given.get("u", 0.0)):
            # The flow measures its errors by the state, and against none a push from the hanging rest is infinitely large.
            x = np.full(len(x), SMALLEST[self.system.real])
        found: P = self.propagate(x[:nq], x[nq:], t, t_end, self.tol, **given)
        return found


@dataclass(frozen=True, eq=False)
class Stretch(Held):
    """One call of a flow.

    Attributes:
        t: Where it began, s.
        x: The state there.
        options: What the call went on with, and its input.
        t1: Where it ended, s.
        found: What it found.
        is_own: Whether it was asked for the ends of its own steps.
    """

    t: float
    x: Vector
    options: Mapping[str, Any]
    t1: float
    found: Propagation
    is_own: bool

    @property
    def ends(self) -> Vector:
        """When its own steps ended; the last of them where it did, which single precision may not hold."""
        return np.append(self.found.t_at[:-1], self.t1) if self.found.t_at.size else self.found.t_at


Asks = Callable[[float], Vector] | None
"""The times wanted of a call that goes to some time; None for the ends of its own steps."""


def _calls(problem: Problem, run: EmittedFlow[P], ledger: Ledger, asks: Asks) -> Iterable[Stretch]:
    """One call of the flow after the other, leg by leg, to the end, the budget or the last finite number."""
    if problem.input is not None or problem.progress is not None:
        return _legs(problem, run, ledger, asks)
    t, t_end = problem.t[[0, -1]].tolist()
    return (_stretch(run, t, problem.x0, t_end, problem.max_steps, asks),)


def _legs(problem: Problem, run: EmittedFlow[P], ledger: Ledger, asks: Asks) -> Iterator[Stretch]:
    """The same where an input has breaks, or somebody is told how far it came."""
    legs = ledger.legs = problem.legs()
    t, x, t_end = float(problem.t[0]), problem.x0, float(problem.t[-1])
    tried, told = 0, 0.0
    while t != t_end:
        leg = legs.take(t, x)
        run.hold(leg.held)
        while t != leg.t1:
            left = problem.max_steps - tried
            stretch = _stretch(run, t, x, leg.t1, left if problem.progress is None else min(left, OFTEN), asks)
            found, t = stretch.found, stretch.t1
            x, tried = np.concatenate((found.q, found.v)), tried + found.tried
            told = tell(problem, t, told, found.outcome == "step budget")
            yield stretch
            if found.outcome != "done" and (found.outcome != "step budget" or tried >= problem.max_steps):
                return


def _stretch(run: EmittedFlow[P], t: float, x: Vector, t1: float, budget: int, asks: Asks) -> Stretch:
    """One call of the flow, and what makes it the same call again."""
    options = run.options
    if asks is None:
        found = run(t, x, t1, max_steps=budget, own=True)
    else:
        times = asks(t1)
        found = run(t, x, t1, max_steps=budget, times=times if len(times) else ())
    return Stretch.made(t=t, x=x, options=options, t1=reached(found, t1), found=found, is_own=asks is None)


def whole_path(problem: Problem, run: EmittedFlow[P], ledger: Ledger) -> tuple[Path, int]:
    """The states at the problem's times, in compiled code from end to end, and how many steps were refused on the way."""
    grid, nq = problem.t, run.system.nq
    way = 1.0 if grid[-1] > grid[0] else -1.0
    states, filled = np.empty((len(grid) + 1, len(problem.x0))), 1
    states[0] = problem.x0

    def asks(stop: float) -> Vector:
        # A time that is the end of a leg belongs to it.
        return grid[filled : int(np.searchsorted(way * grid, way * stop, side="right"))]

    stretches: list[Stretch] = []
    for stretch in _calls(problem, run, ledger, asks):
        found = stretch.found
        end = filled + len(found.q_at)
        states[filled:end, :nq], states[filled:end, nq:] = found.q_at, found.v_at
        stretches.append(stretch)
        filled = end
    times = grid[:filled]
    if times[-1] != stretch.t1:
        times = np.append(times, stretch.t1)
        states[filled, :nq], states[filled, nq:] = found.q, found.v
    status, message = _ended(found, problem, run.name)
    if ledger.account is not None:
        ledger.account.owe(partial(_book, run, stretches, ledger.account))
    steps = sum(stretch.found.steps for stretch in stretches)
    refused = sum(stretch.found.tried for stretch in stretches) - steps
    return Path.made(t=times, x=states[: len(times)], status=status, message=message, crossings=(), steps=steps, dense=None, off=run.off(len(times))), refused


def own_path(problem: Problem, run: EmittedFlow[P], ledger: Ledger) -> tuple[Path, int]:
    """The states at the ends of the flow's own steps, in compiled code from end to end, and how many were refused on the way."""
    stretches = list(_calls(problem, run, ledger, None))
    steps, tried, count, nq, at = 0, 0, 1, run.system.nq, 1
    for stretch in stretches:
        found = stretch.found
        steps, tried, count = steps + found.steps, tried + found.tried, count + len(found.t_at)
    times, states = np.empty(count), np.empty((count, len(problem.x0)))
    times[0], states[0] = problem.t[0], problem.x0
    for stretch in stretches:
        end = at + len(stretch.found.t_at)
        times[at:end], states[at:end, :nq], states[at:end, nq:] = stretch.found.t_at, stretch.found.q_at, stretch.found.v_at
        if end > at:
            times[end - 1] = stretch.t1
        at = end
    times.setflags(write=False)
    states.setflags(write=False)
    again = partial(_again, run, stretches)
    if ledger.account is not None:
        ledger.account.owe(partial(_book, run, stretches, ledger.account))
    status, message = _ended(found, problem, run.name)
    return Path.made(t=times, x=states, status=status, message=message, crossings=(), steps=steps, dense=again, off=run.off(count)), tried - steps


def _states(found: Propagation) -> Vector:
    """The states (m, nx) that were passed on the way."""
    return np.concatenate((found.q_at, found.v_at), axis=1)


def _again(run: EmittedFlow[P], stretches: list[Stretch], times: Vector) -> Vector:
    """The states at other times of a run: from the same start the same series."""
    last, end = stretches[-1].t1, stretches[-1].found
    way = 1.0 if last >= stretches[0].t else -1.0
    states = np.tile(np.concatenate((end.q, end.v)), (len(times), 1))
    inside = np.flatnonzero(times != last)
    inside = inside[np.argsort(way * times[inside], kind="stable")]
    of_stretch = np.searchsorted([way * stretch.t1 for stretch in stretches], way * times[inside], side="left")
    for k in np.unique(of_stretch).tolist():
        stretch, here = stretches[k], inside[of_stretch == k]
        # The call may have been cut, which changes its last bits: one step more than it took is enough for all.
        found = run.once(
            stretch.t, stretch.x, stretch.t1, times=times[here], max_steps=stretch.found.tried + 1, **stretch.options
        )
        states[here[: len(found.q_at)]] = _states(found)
    return states


def _book(run: EmittedFlow[P], stretches: list[Stretch], account: Account) -> None:
    """Enter the steps of a run into its books: the flow is asked once more, for the states within steps."""
    for stretch in stretches:
        u, own = stretch.options.get("u", np.empty(0)), stretch
        if not stretch.is_own:
            found = run.once(stretch.t, stretch.x, stretch.t1, own=True, max_steps=stretch.found.tried, **stretch.options)
            own = replace(stretch, found=found)
        knots = np.concatenate([[stretch.t], own.ends])
        starts = np.concatenate([stretch.x[None], _states(own.found)])
        for first in range(0, len(knots) - 1, _BOOKED):
            within = knots[first : first + _BOOKED + 1]
            points, more = account.points(within, run.points), run.restart(float(within[1] - within[0]))
            found = run.once(float(within[0]), starts[first], float(within[-1]), times=points, u=u, **more)
            if len(found.q_at) < len(points):  # it left the finite numbers
                return
            account.book(within, run.points, _states(found), u)


def reached(found: Propagation, t_end: float) -> float:
    """Where a call came to: at its end the time that was asked for, which single precision may not hold."""
    return t_end if found.outcome == "done" else found.t


def dense(at: StateAt) -> Callable[[], StateAt]:
    """A segment's states in between, which nothing has to be prepared for."""
    return lambda: at


def _ended(found: Propagation, problem: Problem, name: str) -> tuple[str, str]:
    """Status and message of a run by its last call."""
    if found.outcome == "done":
        return "complete", ""
    t_end = float(problem.t[-1])
    if found.outcome == "step budget":
        return "step budget", f"{problem.max_steps} steps, the budget, brought it to t = {found.t:.6g} s of {t_end:.6g} s"
    size = float(max(np.max(np.abs(found.q)), np.max(np.abs(found.v))))
    return "blow-up", f"{name} left the finite numbers at t = {found.t:.6g} s (largest entry {size:.3g})"
