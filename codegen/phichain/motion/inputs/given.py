"""What a caller gives as u, sample, delay and limit, checked before the run, as one Input."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from phichain.errors import ArrayError, ToleranceError, UnsupportedError
from phichain.motion.inputs.legs import Legs, Planned, Sampled
from phichain.motion.inputs.limits import Limits, as_limits
from phichain.motion.inputs.names import position
from phichain.motion.inputs.piece import Constant, Law, Signal, Together
from phichain.motion.inputs.shield import shielded
from phichain.motion.inputs.table import Table
from phichain.records import Held
from phichain.system import System, Vector, input_arguments
from phichain.system.arrays import number, positive

SHORTEST = 1024 * float(np.finfo(float).eps)
"""A period below this part of a run's times cannot be told from none."""
FORMS = "give a constant vector, a callable u(t, x), a Table, or any of them by name"


@dataclass(frozen=True, eq=False)
class Input(Held):
    """The input of a run: what it is, when it is sampled, and how late it comes.

    Attributes:
        signal: The inputs over time and state, within their limits.
        sample: Period of a zero-order hold, s, or None.
        delay: How long a sampled input is under way, s.
        before: What the input is until the first sample arrives (nu,): zero, or the limit nearest to it.
    """

    signal: Signal
    sample: float | None
    delay: float
    before: Vector

    @property
    def is_held(self) -> bool:
        """Whether it is constant between its breaks, so that a method which holds u can run from one to the next."""
        return self.sample is not None or self.signal.is_held

    @property
    def has_breaks(self) -> bool:
        """Whether it is more than one constant or one law."""
        return self.sample is not None or not isinstance(self.signal, Constant | Law)

    @property
    def remarks(self) -> list[str]:
        """What a reader of the result must know of it."""
        if self.sample is None:
            return []
        until = f", acting {self.delay:g} s later ({self.before.tolist()} until then)" if self.delay else ""
        return [f"u was sampled every {self.sample:g} s and held{until}"]

    @property
    def constant(self) -> Vector | None:
        """The input where it never changes, else None."""
        return self.signal.u if self.sample is None and isinstance(self.signal, Constant) else None

    def at_rest(self, t: float, x: Vector) -> Vector:
        """What the input is before the first sample arrives."""
        return self.before

    def legs(self, t0: float, t_end: float) -> Legs:
        """The stretches of a run from one break to the next, to be taken in their order."""
        if self.sample is None:
            return Planned(self.signal, t0, t_end)
        return Sampled(self.signal, self.sample, self.delay, self.before, t0, t_end)


def as_input(
    system: System, u: Any, span: tuple[float, float], sample: Any = None, delay: Any = 0.0, limit: Any = None
) -> Input | None:
    """The input of a run over a span of time; None for a system without inputs.

    Raises:
        ArrayError: A wrong shape, a value that is not finite, an unknown name, a table that does not cover the run, or an input
            given to a system that has none.
        ToleranceError: sample is not positive, or delay negative.
        UnsupportedError: delay without sample, or a sampled input in a run backwards in time.
    """
    if u is None and sample is None and limit is None and not system.nu and type(delay) is float and delay == 0.0:
        return None
    limits = as_limits(system, limit)
    period = None if sample is None else _period(sample, span)
    late = number("delay", delay, "give a delay in s", ToleranceError)
    if late < 0:
        raise ToleranceError("delay", delay, "must not be negative", "give how late the computed input arrives, in s")
    if late and period is None:
        raise UnsupportedError(
            "delay", delay, "delays what a law computed at its samples", "give sample= too, or shift the times of a table"
        )
    signal = _signal(system, u, span, limits)
    if signal is None:
        return None
    zero = np.zeros(system.nu)
    is_sampled = not isinstance(signal, Constant) or late > 0
    return Input(signal, period if is_sampled else None, late, zero if limits is None else limits.cut(zero))


def _period(sample: Any, span: tuple[float, float]) -> float:
    period = positive("sample", sample, "give the time between two samples in s")
    if span[1] < span[0]:
        raise UnsupportedError("sample", sample, "samples forwards in time, and the run goes backwards", "give rising times")
    if period <= SHORTEST * max(abs(span[0]), abs(span[1])):
        raise ToleranceError("sample", sample, "is lost in the round-off of the run's times", "sample at longer intervals")
    return period


def _signal(system: System, u: Any, span: tuple[float, float], limits: Limits | None) -> Signal | None:
    if isinstance(u, Mapping):
        return _by_name(system, u, span, limits)
    if callable(u):
        return Law(shielded("u", system.nu, u, limits))
    table = _table(u)
    if table is not None:
        return _covering(table, "u", system.nu, span, limits)
    held = constant_input(system, u)
    return None if held is None else Constant(held if limits is None else limits.cut(held))


def _by_name(system: System, given: Mapping[Any, Any], span: tuple[float, float], limits: Limits | None) -> Signal:
    if not given:
        raise ArrayError("u", given, "names no input", "name one, or leave u out")
    parts = []
    for name, u in given.items():
        at, field = (position(system, "u", name),), f"u.{name}"
        own, table = None if limits is None else limits.of(at), _table(u)
        part: Signal
        if callable(u):
            part = Law(shielded(field, 1, u, own, alone=True))
        elif table is not None:
            part = _covering(table, field, 1, span, own)
        else:
            value = np.array([number(field, u, FORMS)])
            part = Constant(value if own is None else own.cut(value))
        parts.append((at, part))
    together = Together(tuple(parts), system.nu)
    still = all(isinstance(part, Constant) for _, part in parts)
    return Constant(together.value(0.0, np.empty(0))) if still else together


def _table(u: Any) -> Table | None:
    """The table that is meant, also by a plain tuple (times, values) or (times, values, between)."""
    if isinstance(u, Table):
        return u
    is_plain = isinstance(u, tuple) and len(u) in (2, 3) and isinstance(u[0], list | tuple | np.ndarray) and np.ndim(u[0]) > 0
    return Table(*u) if is_plain else None


def _covering(table: Table, field: str, size: int, span: tuple[float, float], limits: Limits | None) -> Table:
    if table.values.shape[1] != size:
        problem = f"must hold {size} input{'' if size == 1 else 's'} in every row"
        raise ArrayError(f"{field}.values", table.values.shape, problem, "give one column per input, or a table per name")
    table.demand_cover(field, min(span), max(span))
    return table if limits is None else table.within(limits.low, limits.high)


def constant_input(system: System, u: Any) -> Vector | None:
    """One input vector (nu,), zero by default, None for a system without inputs.

    Raises:
        ArrayError: Wrong shape, not finite, or given to a system without inputs.
    """
    given = input_arguments(system, np.zeros(system.nq), u)
    if not given:
        return None
    held = given[0]
    if held.shape != (system.nu,):
        raise ArrayError("u", held.shape, f"must have shape ({system.nu},)", FORMS)
    if not np.all(np.isfinite(held)):
        raise ArrayError("u", held.tolist(), "is not finite", "give finite inputs")
    return held
