"""From a method's steps to a path: outputs, events, budget and progress, the same for every method.

A method is a generator of `Segment`s, one per accepted step; `collect` does the rest.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np

from phichain.motion.balance import FEW, Account
from phichain.motion.events import Crossing, Watch
from phichain.motion.inputs.piece import Control
from phichain.motion.problem import Problem
from phichain.records import Held
from phichain.system import Vector

#: Steps after which progress is reported however little it is.
OFTEN: Final = 1000

StateAt = Callable[[float], Vector]
StatesAt = Callable[[Vector], Vector]
"""States (m, nx) at times (m,) in any order."""


class StalledError(Exception):
    """A method cannot go on from the last segment it gave; the text says why."""


class BudgetError(StalledError):
    """A method that counts its steps itself ran out of them."""


@dataclass(frozen=True, eq=False)
class Segment(Held):
    """One accepted step.

    Attributes:
        t0: Its start, s.
        t1: Its end, s.
        x1: State at the end.
        dense: Makes the state at any time within it; called only when someone looks inside.
        parts: Into how many pieces it is cut to look for events.
        takes_many: Whether what `dense` makes takes an array of times too, and gives one column for each.
        looks: States at several times within it at once, where a method has a cheaper way than one by one.
        points: At how many points within it powers are looked at, as the order of its states needs.
        control: u(t, x) during the step; None where the problem's own input says it.
    """

    t0: float
    t1: float
    x1: Vector
    dense: Callable[[], StateAt]
    parts: int = 4
    takes_many: bool = False
    looks: StatesAt | None = None
    points: int = FEW
    control: Control | None = None


@dataclass(frozen=True, eq=False)
class Dense(Held):
    """The state at any time of a path, piece by piece as the method interpolates it."""

    knots: Vector
    pieces: tuple[StateAt, ...]

    def __call__(self, times: Vector) -> Vector:
        """States (m, nx) at times (m,)."""
        order = 1 if self.knots[-1] >= self.knots[0] else -1
        at = np.searchsorted(order * self.knots[1:-1], order * times, side="left")
        return np.array([self.pieces[k](float(t)) for k, t in zip(at, times, strict=True)])


@dataclass(frozen=True, eq=False)
class Path(Held):
    """What a method found.

    Attributes:
        t: Times (m,).
        x: States (m, nx).
        status: "complete", "event", "step budget", "blow-up" or "stalled".
        message: Why it ended early; empty when it did not.
        crossings: Events met, in order.
        steps: Accepted steps.
        dense: The states in between, kept when the outputs are the method's own steps.
        off: Finds by neighbours of its steps how large the errors of q and of v are (m, 2); None where it left none.
    """

    t: Vector
    x: Vector
    status: str
    message: str
    crossings: tuple[Crossing, ...]
    steps: int
    dense: StatesAt | None
    off: Callable[[], Vector] | None = None


class _Inside:
    """The state within one segment: its interpolant made at the first look, its end exact."""

    def __init__(self, segment: Segment) -> None:
        self.segment = segment
        self.made: StateAt | None = None

    def __call__(self, t: float) -> Vector:
        if t == self.segment.t1:
            return self.segment.x1
        return self.make()(t)

    def make(self) -> StateAt:
        # A solver's interpolant is that of its newest step: it must be made before the solver goes on.
        if self.made is None:
            self.made = self.segment.dense()
        return self.made


@dataclass
class _Recorder:
    """Outputs so far, and the next output time waited for."""

    problem: Problem
    t: list[float] = field(default_factory=list)
    x: list[Vector] = field(default_factory=list)
    pieces: list[StateAt] = field(default_factory=list)
    waiting: int = 1

    def add(self, t: float, x: Vector) -> None:
        self.t.append(t)
        self.x.append(np.array(x))

    def keep(self, inside: _Inside, stop: float, x_stop: Vector) -> None:
        """Record a segment up to `stop`, where the state is `x_stop`."""
        if self.problem.own_steps:
            self.add(stop, x_stop)
            self.pieces.append(inside.make())
            return
        grid = self.problem.t
        order = np.sign(grid[-1] - grid[0])
        while self.waiting < len(grid) and order * (stop - grid[self.waiting]) >= 0:
            t = float(grid[self.waiting])
            self.add(t, x_stop if t == stop else inside(t))
            self.waiting += 1

    def dense(self) -> Dense | None:
        """The state at any time, when the outputs are the method's own steps."""
        return Dense(np.array(self.t[: len(self.pieces) + 1]), tuple(self.pieces)) if self.pieces else None


def collect(problem: Problem, segments: Iterator[Segment], account: Account | None = None) -> Path:
    """Drive a method to its end: record outputs, watch events, keep to the budget, book work and loss, report progress."""
    t0, t_end = float(problem.t[0]), float(problem.t[-1])
    recorder = _Recorder(problem)
    recorder.add(t0, problem.x0)
    watch = Watch.start(problem.events, t0, problem.x0)
    crossings: list[Crossing] = []
    steps, told = 0, 0.0
    status, message = "complete", ""
    last = (t0, problem.x0)
    try:
        for segment in segments:
            steps += 1
            inside = _Inside(segment)
            watch, found, terminal = watch.advance(inside, _knots(segment, problem))
            crossings += found
            if account is not None:
                _book(account, problem, segment, inside, segment.t1 if terminal is None else terminal.t)
            if terminal is not None:
                recorder.keep(inside, terminal.t, terminal.x)
                last = (terminal.t, terminal.x)
                status, message = "event", f"event '{terminal.name}' ended it at t = {terminal.t:.17g} s"
                break
            recorder.keep(inside, segment.t1, segment.x1)
            last = (segment.t1, segment.x1)
            told = tell(problem, segment.t1, told, steps % OFTEN == 0)
            if steps >= problem.max_steps and segment.t1 != t_end:
                status = "step budget"
                message = f"{steps} steps, the budget, brought it to t = {segment.t1:.6g} s of {t_end:.6g} s"
                break
    except BudgetError:
        status = "step budget"
        message = f"{problem.max_steps} steps, the budget, did not bring it beyond t = {last[0]:.6g} s of {t_end:.6g} s"
    except StalledError as failure:
        status, message = _diagnose(problem, *last, str(failure))
    if recorder.t[-1] != last[0]:
        recorder.add(*last)
    return Path(
        np.array(recorder.t), np.array(recorder.x), status, message, tuple(crossings), steps, recorder.dense()
    )


def _book(account: Account, problem: Problem, segment: Segment, inside: _Inside, stop: float) -> None:
    """Enter a segment, up to where the run stopped, into the books."""
    control = segment.control or problem.control or (lambda t, x: np.empty(0))
    if stop == segment.t0:
        return
    knots = np.array([segment.t0, stop])
    times = account.points(knots, segment.points)
    if segment.looks is not None:
        states = segment.looks(times)
    else:
        at: Any = inside.make()
        states = np.asarray(at(times)).T if segment.takes_many else np.array([at(t) for t in times.tolist()])
    account.book(knots, segment.points, states, control)


def _knots(segment: Segment, problem: Problem) -> list[float]:
    parts = segment.parts if problem.events else 1
    inner = np.linspace(segment.t0, segment.t1, parts + 1)[1:-1].tolist()
    return [segment.t0, *inner, segment.t1]


def tell(problem: Problem, t: float, told: float, is_due: bool = False) -> float:
    """Report progress whenever another hundredth is done, or it is due; returns what was told last."""
    if problem.progress is None:
        return told
    done = (t - problem.t[0]) / (problem.t[-1] - problem.t[0])
    if done < told + 0.01 and done < 1 and not is_due:
        return told
    problem.progress(float(done), t)
    return float(done)


def _diagnose(problem: Problem, t: float, x: Vector, cause: str) -> tuple[str, str]:
    """Tell a finite-time blow-up from a tolerance that cannot be kept."""
    size = float(np.max(np.abs(x)))
    slope = problem.field.function(t, x)
    if not np.all(np.isfinite(slope)) or size > 1e8 * (1 + float(np.max(np.abs(problem.x0)))):
        return "blow-up", f"the solution leaves every bound at t = {t:.6g} s (largest entry {size:.3g})"
    return "stalled", f"{cause} at t = {t:.6g} s (largest entry {size:.3g})"
