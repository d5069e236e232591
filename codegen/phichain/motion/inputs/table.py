"""Tables of inputs: values at rising times, held until the next one or joined by straight lines."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from phichain.errors import ArrayError
from phichain.motion.inputs.piece import Piece, Signal
from phichain.records import Held
from phichain.system import Vector
from phichain.system.arrays import reals

BETWEEN: Final = ("held", "linear")
ROUND_OFF: Final = 8 * float(np.finfo(float).eps)
"""By how much of themselves two times may differ that are meant to be one."""


@dataclass(frozen=True, eq=False)
class Table(Held, Signal):
    """Inputs u(t_i) at times t_i.

    Held, u(t) = u_i for t_i <= t < t_(i+1), which is what a zero-order hold puts out; linear, u(t) runs straight from one row to
    the next. The run may not begin before the first time nor end after the last.

    Attributes:
        times: t_i (m,), s, strictly rising.
        values: u_i (m, k), or (m,) for one input; N, N m, m/s^2 as the input is.
        between: "held" or "linear".

    Raises:
        ArrayError: A shape that does not fit, a value that is not finite, times that do not rise.
    """

    times: Vector
    values: Vector
    between: str = "held"

    def __post_init__(self) -> None:
        times = np.array(reals("u.times", self.times, "give times in s"))
        values = np.array(reals("u.values", self.values, "give one row of inputs for every time"))
        if times.ndim != 1 or not times.size:
            raise ArrayError("u.times", times.shape, "is no list of times", "give them one after the other")
        if values.ndim not in (1, 2) or len(values) != len(times):
            raise ArrayError(
                "u.values", values.shape, f"must hold {len(times)} rows, one for every time", "give one row of inputs for every time"
            )
        for field, array in (("u.times", times), ("u.values", values)):
            if not np.isfinite(array).all():
                raise ArrayError(field, array, f"holds a value that is not finite in row {_first(~np.isfinite(array))}", "mend it")
        if (np.diff(times) <= 0).any():
            row = _first(np.diff(times) <= 0)
            raise ArrayError(
                "u.times", (float(times[row - 1]), float(times[row])), f"do not rise from row {row} to row {row + 1}",
                "sort the table and drop repeated times",
            )  # fmt: skip
        if self.between not in BETWEEN:
            raise ArrayError("u.between", self.between, "is no way from one row to the next", f"use {' or '.join(BETWEEN)}")
        for name, array in (("times", times), ("values", values.reshape(len(times), -1))):
            object.__setattr__(self, name, array)
        super().__post_init__()

    @property
    def is_held(self) -> bool:
        """Whether it is constant between breaks."""
        return self.between == "held"

    def demand_cover(self, field: str, low: float, high: float) -> None:
        """Refuse a table that does not reach over a whole run.

        Raises:
            ArrayError: It begins after the run's start, or ends before its end.
        """
        first, last = float(self.times[0]), float(self.times[-1])
        slack = ROUND_OFF * max(abs(low), abs(high))
        wrong = "begins after" if first > low + slack else "ends before" if last < high - slack else ""
        if wrong:
            raise ArrayError(
                field, (first, last), f"is a table of inputs that {wrong} the run, which takes from {low:g} to {high:g} s",
                "repeat its first or last row there, or shorten the run",
            )  # fmt: skip

    def within(self, low: Vector, high: Vector) -> Table:
        """The same, cut off at limits; a straight line gets a further row where it meets one."""
        if self.between == "held":
            return Table(self.times, np.clip(self.values, low, high), self.between)
        times = np.unique(np.concatenate([self.times, *(self._meets(bound) for bound in (low, high))]))
        drawn = np.column_stack([np.interp(times, self.times, column) for column in self.values.T])
        return Table(times, np.clip(drawn, low, high), self.between)

    def _meets(self, bound: Vector) -> Vector:
        """Times within rows at which an entry passes its bound."""
        before, after = self.values[:-1] - bound, self.values[1:] - bound
        row, column = np.nonzero(before * after < 0)
        share = before[row, column] / (before[row, column] - after[row, column])
        met: Vector = self.times[row] + share * (self.times[row + 1] - self.times[row])
        return met[np.isfinite(met)]

    def breaks(self, low: float, high: float) -> Vector:
        """Rows at which a held value changes, or the slope of a line does."""
        rows = np.diff(self.values, axis=0)
        if self.between == "linear":
            rows = np.diff(rows / np.diff(self.times)[:, None], axis=0)
        at = self.times[1 : 1 + len(rows)][np.any(rows != 0, axis=1)]
        found: Vector = at[(at > low) & (at < high)]
        return found

    def piece(self, start: float, stop: float) -> Piece:
        """The row that holds there, or the line."""
        k = self._row((start + stop) / 2)
        if self.between == "held" or k == len(self.times) - 1:
            return Piece.constant(self.values[k])
        t0, u0 = float(self.times[k]), self.values[k]
        width, rise = float(self.times[k + 1]) - t0, self.values[k + 1] - u0
        return Piece(lambda t, x: u0 + (t - t0) / width * rise, None) if rise.any() else Piece.constant(u0)

    def value(self, t: float, x: Vector) -> Vector:
        """The inputs at one moment."""
        k = self._row(t)
        return self.values[k] if self.between == "held" else self.piece(t, t).control(t, x)

    def _row(self, t: float) -> int:
        """The last row that is not after a time."""
        return max(0, int(np.searchsorted(self.times, t, side="right")) - 1)


def _first(where: NDArray[np.bool_]) -> int:
    """The first row, counted from 1, in which something holds."""
    return int(np.argmax(where.reshape(len(where), -1).any(axis=1))) + 1
