"""A run cut at the breaks of its input: legs on which the input is one constant or one smooth function."""

from __future__ import annotations

from abc import ABC, abstractmethod
from bisect import bisect_right
from collections import deque
from dataclasses import dataclass

from phichain.motion.inputs.piece import Control, Piece, Signal
from phichain.motion.inputs.table import ROUND_OFF
from phichain.records import Held
from phichain.system import Vector

MEANT = 1e-9
"""A delay that is a multiple of the period to this part of it is one."""


@dataclass(frozen=True, eq=False)
class Leg(Held):
    """A stretch of a run without breaks of the input inside.

    Attributes:
        t1: Its end, s.
        control: u(t, x) on it.
        held: The input where it is constant on it, else None.
    """

    t1: float
    control: Control
    held: Vector | None

    @classmethod
    def of(cls, t1: float, piece: Piece) -> Leg:
        """A leg with one piece of an input."""
        return cls.made(t1=t1, control=piece.control, held=piece.held)


class Legs(ABC):
    """The legs of one run, taken in their order: what a law that samples puts out is known when its leg begins."""

    @abstractmethod
    def take(self, t: float, x: Vector) -> Leg:
        """The leg that begins at (t, x)."""

    @abstractmethod
    def value(self, t: float, x: Vector) -> Vector:
        """The input at a moment of a leg that was taken; at a jump that after it."""


class Planned(Legs):
    """Legs between breaks that are known beforehand."""

    def __init__(self, signal: Signal, t0: float, t_end: float) -> None:
        """Look up the breaks between start and end, in the direction of the run."""
        self.signal, self._at = signal, 0
        inside = signal.breaks(min(t0, t_end), max(t0, t_end))
        if not inside.size:
            self._stops = [t_end]
            return
        slack = ROUND_OFF * max(abs(t0), abs(t_end))
        # Two tables may mean one time by two neighbouring numbers: no step is taken between them.
        known = [t0]
        for t in (inside if t_end > t0 else inside[::-1]).tolist():
            if abs(t - known[-1]) > slack and abs(t_end - t) > slack:
                known.append(t)
        self._stops = [*known[1:], t_end]

    def take(self, t: float, x: Vector) -> Leg:
        """The leg to the next break."""
        stop = self._stops[self._at]
        self._at += 1
        return Leg.of(stop, self.signal.piece(t, stop))

    def value(self, t: float, x: Vector) -> Vector:
        """What the signal is then."""
        return self.signal.value(t, x)


class Sampled(Legs):
    """Legs of an input that is computed at t_k = t_0 + k T and acts, held, from t_k + delay to t_(k+1) + delay.

    The signal is asked once at every sample, in their order, with the state there, so it may remember what it saw.
    """

    def __init__(self, signal: Signal, period: float, delay: float, before: Vector, t0: float, t_end: float) -> None:
        """Begin at the first sample, with `before` until it arrives."""
        self.signal, self.period, self.t0, self.t_end = signal, period, t0, t_end
        # What arrives after the end need not be counted exactly.
        whole, part = divmod(min(delay, (t_end - t0) + 2 * period), period)
        if part > (1 - MEANT) * period:
            whole, part = whole + 1, 0.0
        self.part = part if part > MEANT * period else 0.0
        self._under_way: deque[Vector] = deque([before] * int(whole))
        self._acting, self._samples, self._has_sampled = before, 0, False
        self._since: list[float] = []
        self._acted: list[Vector] = []

    def take(self, t: float, x: Vector) -> Leg:
        """Sample where a sample is due, let act what arrives, and go on to the next moment of either."""
        if not self._has_sampled:
            self._under_way.append(self.signal.value(t, x))
            self._samples += 1
        # A delay of no whole number of periods: what was sampled earlier still acts for a part of this one.
        self._has_sampled = self.part > 0 and not self._has_sampled
        if not self._has_sampled:
            self._acting = self._under_way.popleft()
        self._since.append(t)
        self._acted.append(self._acting)
        return Leg.of(self._stop(), Piece.constant(self._acting))

    def _stop(self) -> float:
        """The next sample, or the arrival before it; the end of the run where that is nearer, or the same but for round-off."""
        last = self._samples - 1
        stop = self.t0 + last * self.period + self.part if self._has_sampled else self.t0 + self._samples * self.period
        slack = ROUND_OFF * max(abs(self.t0), abs(self.t_end))
        return stop if self.t_end - stop > slack else self.t_end

    def value(self, t: float, x: Vector) -> Vector:
        """What was put out then."""
        return self._acted[max(bisect_right(self._since, t) - 1, 0)]
