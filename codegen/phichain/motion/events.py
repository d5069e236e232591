"""Events: named scalars g(t, x) whose sign changes are located along a simulation.

A scalar that turns round between two looks may have crossed zero twice, so its rate is looked at as well: where it falls towards
zero at the one and away from it at the other, its extremum is sought, and what lies on the far side of zero is a pair of crossings
however close they are.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.optimize import brentq, minimize_scalar

from phichain.errors import ArrayError
from phichain.records import Held
from phichain.system import Vector
from phichain.system.arrays import number, reals, whole

Scalar = Callable[[float, Vector], float]
Look = tuple[float, float, float]
"""A time, a scalar's value then, and its rate."""

#: How far from a look its rate is measured, and how exactly an extremum is found: parts of the time between two looks.
_CLOSE, _EXACTLY = 1e-4, 1e-10
#: A scalar that is further from zero than so many times what its rate makes of the time between two looks is not sought there.
_REACH = 2.0


@dataclass(frozen=True)
class Event:
    """A scalar of time and state that is watched for sign changes.

    Attributes:
        name: How its crossings are called in the Trajectory.
        function: g(t, x).
        direction: +1 records rising crossings only, -1 falling ones, 0 both; along the direction of integration.
        terminal: True ends the simulation at the first crossing.
    """

    name: str
    function: Scalar
    direction: int = 0
    terminal: bool = False

    def __post_init__(self) -> None:
        if not callable(self.function):
            raise ArrayError("event.function", self.function, "cannot be called", "give a callable g(t, x)")
        if not isinstance(self.name, str):
            raise ArrayError("event.name", self.name, "is no text", "name the event")
        direction = whole("event.direction", self.direction, -1, 1, "use -1, 1, or 0 for both directions", ArrayError)
        object.__setattr__(self, "direction", direction)

    def value(self, t: float, x: Vector) -> float:
        """g(t, x); the function is given a state of its own, so that what it writes there changes no motion.

        Raises:
            ArrayError: It is no number.
        """
        answer = self.function(t, np.array(x))
        value = reals(f"event '{self.name}'", answer, "return one number")
        if value.size != 1 or np.isnan(value).any():
            raise ArrayError(f"event '{self.name}'", answer, f"gives no number at t = {t:.6g} s", "return one number")
        return float(value.item())


@dataclass(frozen=True, eq=False)
class Crossing(Held):
    """One located sign change.

    Attributes:
        name: The event's name.
        t: Time of the crossing, s.
        x: State (q, v) there.
        doubtful: Whether it lies beyond the time until which the run holds, so that it may never happen.
    """

    name: str
    t: float
    x: Vector
    doubtful: bool = False


def marked(crossings: Iterable[Crossing], t: Vector, holds_until: float) -> tuple[Crossing, ...]:
    """Crossings of a run at times t (m,), with those marked that lie beyond the time until which it holds."""
    way = 1 if t[-1] >= t[0] else -1
    return tuple(replace(crossing, doubtful=True) if way * (crossing.t - holds_until) > 0 else crossing for crossing in crossings)


def as_events(events: Iterable[Event | Scalar] | Event | Scalar | None) -> tuple[Event, ...]:
    """Events from records and from plain callables, whose attributes `direction` and `terminal` are honoured."""
    if events is None:
        return ()
    if isinstance(events, Event) or callable(events):
        events = (events,)
    try:
        events = tuple(events)
    except TypeError as failure:
        raise ArrayError("events", events, "holds no events", "give Event records or callables g(t, x)") from failure
    return tuple(_as_event(event, k) for k, event in enumerate(events))


def _as_event(event: Any, k: int) -> Event:
    if isinstance(event, Event):
        return event
    name = getattr(event, "__name__", f"event_{k + 1}")
    direction = int(np.sign(number("event.direction", getattr(event, "direction", 0), "use -1, 0 or 1")))
    return Event(name, event, direction, bool(getattr(event, "terminal", False)))


@dataclass(frozen=True, eq=False)
class Watch(Held):
    """The events together with their values at the last point seen, and their rates there, 1/s; None before the first."""

    events: tuple[Event, ...]
    values: Vector
    rates: Vector | None = None

    @classmethod
    def start(cls, events: tuple[Event, ...], t: float, x: Vector) -> Watch:
        """Begin watching at (t, x)."""
        return cls(events, _values(events, t, x))

    def advance(
        self, state_at: Callable[[float], Vector], knots: Sequence[float]
    ) -> tuple[Watch, list[Crossing], Crossing | None]:
        """Look for sign changes between successive knots, the first of which is the last point seen.

        Args:
            state_at: State at any time between the first and the last knot.
            knots: Times in the order of integration.

        Returns:
            The watch at the last knot, the crossings in order, and the terminal one that ends the run (then
            nothing after it is listed).
        """
        found: list[Crossing] = []
        watch = self
        for start, stop in pairwise(knots):
            watch, here = watch._between(state_at, start, stop)
            here.sort(key=lambda crossing: abs(crossing.t - start))
            for crossing in here:
                found.append(crossing)
                if watch._is_terminal(crossing.name):
                    return watch, found, crossing
        return watch, found, None

    def _between(
        self, state_at: Callable[[float], Vector], start: float, stop: float
    ) -> tuple[Watch, list[Crossing]]:
        after = _values(self.events, stop, state_at(stop))
        near = stop - _CLOSE * (stop - start)
        rates = _rates(after, _values(self.events, near, state_at(near)), stop - near)
        first = self._first_rates(state_at, start, stop) if self.rates is None else self.rates
        found = []
        for k, event in enumerate(self.events):
            ends = (start, self.values[k], first[k]), (stop, after[k], rates[k])
            turned = _turned(event, state_at, *ends)
            looks = [ends[0][:2], *([] if turned is None else [turned]), ends[1][:2]]
            for (t0, old), (t1, new) in pairwise(looks):
                if _crossed(event, old, new):
                    t = _root(event, state_at, t0, t1) if new != 0 else t1
                    found.append(Crossing(event.name, t, state_at(t)))
        return Watch(self.events, after, rates), found

    def _first_rates(self, state_at: Callable[[float], Vector], start: float, stop: float) -> Vector:
        near = start + _CLOSE * (stop - start)
        return _rates(_values(self.events, near, state_at(near)), self.values, near - start)

    def _is_terminal(self, name: str) -> bool:
        return any(event.terminal for event in self.events if event.name == name)


def _values(events: tuple[Event, ...], t: float, x: Vector) -> Vector:
    return np.array([event.value(t, x) for event in events])


def _rates(after: Vector, before: Vector, seconds: float) -> Vector:
    with np.errstate(invalid="ignore", over="ignore", divide="ignore"):  # what has no rate here turns nowhere
        return (after - before) / seconds


def _turned(event: Event, state_at: Callable[[float], Vector], first: Look, last: Look) -> tuple[float, float] | None:
    """Where a scalar, on the same side of zero at two looks, is furthest on the other in between, and its value; None where it is not."""
    (start, old, falling), (stop, new, rising) = first, last
    side, seconds = np.sign(old), stop - start
    towards, away = -side * falling * seconds, side * rising * seconds
    if old * new <= 0 or not (towards > 0 and away > 0) or min(abs(old), abs(new)) > _REACH * max(towards, away):
        return None

    def distance(part: float) -> float:
        t = start + part * seconds
        return float(side * event.value(t, state_at(t)))

    least = minimize_scalar(distance, bounds=(0.0, 1.0), method="bounded", options={"xatol": _EXACTLY})
    return (start + float(least.x) * seconds, float(side * least.fun)) if least.fun < 0 else None


def _crossed(event: Event, old: float, new: float) -> bool:
    # A value that starts at zero has not crossed: brake orbits start with their rate at zero.
    changed = old * new < 0 or (new == 0 and old != 0)
    return changed and event.direction in (0, np.sign(new - old))


def _root(event: Event, state_at: Callable[[float], Vector], start: float, stop: float) -> float:
    spacing = 4 * np.finfo(float).eps
    return float(brentq(lambda t: event.value(t, state_at(t)), start, stop, xtol=1e-300, rtol=spacing))
