"""Test vectors of a table with observers or integrals: each equilibrium watched, taken up, held, driven to its limits and let go.

The Programs take no part: all numbers are the formulas of `OutputTable` in 60 digits. Deviations lie on levels clear of those
at which an equilibrium is taken up and let go, so that rounding decides nothing.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Any, Final

import numpy as np
from mpmath import mp
from numpy.typing import NDArray

from phichain.emit.law.cases.rounding import Rounded, total, turned
from phichain.emit.law.cases.state import as_fraction, share
from phichain.ir.rounded import nearest
from phichain.laws import OutputTable

_DIGITS: Final = 60
_INSIDE, _BETWEEN, _NEARLY, _OUTSIDE = 0.25, 0.5, 0.9, 1.5
"""Levels of the cases, as in those of gain tables."""
_OFF: Final = 0.01
"""What a measurement is off what was expected."""

Vector = NDArray[np.float64]
Whole = tuple[int, int, int]


@dataclass(frozen=True)
class Case:
    """One call.

    Attributes:
        before: What is held, what is near, calls.
        after: The same then.
        numbers: Deviation, integrals and y_meas, then the level, u, deviation and integrals that are expected, then how far each of
            these may be off by rounding alone.
    """

    before: Whole
    after: Whole
    numbers: tuple[tuple[float, ...], ...]


def cases(table: OutputTable, real: str) -> tuple[Case, ...]:
    """Each equilibrium in every state that a call can find it in.

    Args:
        table: the table.
        real: "double" or "float", the type of its C.
    """
    found = []
    for which, (settle, take, leave) in enumerate(zip(table.settle, table.take, table.leave, strict=True)):
        made, between = _Maker(table, real, which), take + _BETWEEN * (leave - take)
        free = (-1, which, settle)
        found.append(made.case((-1, -1, 0), _INSIDE * take, started=True))
        found.append(made.case((-1, which, 7), _OUTSIDE * leave))
        found.append(made.case(free, _INSIDE * take))
        found.append(made.case((which, which, settle + 1), _OUTSIDE * leave))
        if between > 1.01 * take:
            found.append(made.case((which, which, settle + 1), between))
            found.append(made.case(free, between))
            found += [made.case((which, which, settle + 1), _NEARLY * leave, side) for side in (1, -1)]
    return tuple(found)


@dataclass(frozen=True)
class _Maker:
    """Calls about one equilibrium."""

    table: OutputTable
    real: str
    which: int

    def case(self, before: Whole, level: float, side: int = 0, started: bool = False) -> Case:
        """One call whose deviation has about that level; driven hardest to a side, or measured for the first time."""
        law = self.table.laws[self.which]
        z = self._deviation(level, side, started)
        expected = np.zeros(len(z))
        if law.observer is None:
            y = np.array(law.offsets) + z
        else:
            off = 0.0 if started else _OFF
            innovation = off * np.array([float(share(i, self.which)) for i in range(len(law.offsets))])
            if not started:
                expected = z - np.array(law.observer.correction) @ innovation
            y = np.array(law.offsets) + np.array(law.observer.seen) @ (z if started else expected) + innovation
        integral = [0.25 * float(share(k, self.which)) for k in range(len(law.integrated))]
        deviation, memory, measured = (tuple(nearest(self.real, Fraction(float(x))) for x in part) for part in (expected, integral, y))
        with mp.workdps(_DIGITS):
            after, values = self._called(before, deviation, memory, measured, started)
            expected_values = tuple(nearest(self.real, as_fraction(value.value)) for value in values)
            allowed = tuple(nearest(self.real, as_fraction(value.allowed(self.real))) for value in values)
        return Case(before, after, (deviation, memory, measured, expected_values, allowed))

    def _deviation(self, level: float, side: int, started: bool) -> Vector:
        law, shape = self.table.laws[self.which], np.array(self.table.shapes[self.which])
        away = np.linalg.lstsq(shape, np.array([float(share(i, self.which)) + 0.01 for i in range(len(shape))]), rcond=None)[0]
        if side:
            away = side * np.linalg.pinv(shape.T @ shape) @ np.array(law.gains[0])
        if started and law.observer:
            away = np.array(law.observer.start) @ np.array(law.observer.seen) @ away
        return np.asarray(away * np.sqrt(level / np.sum((shape @ away) ** 2)))

    def _called(
        self, before: Whole, deviation: tuple[float, ...], memory: tuple[float, ...], measured: tuple[float, ...], started: bool
    ) -> tuple[Whole, list[Rounded]]:
        """The formulas of `OutputTable`, line by line."""
        table, law, which = self.table, self.table.laws[self.which], self.which
        off = [Rounded.of(y, exact=True) - Rounded.of(offset) for y, offset in zip(measured, law.offsets, strict=True)]
        expected = [Rounded.of(x, exact=True) for x in deviation]
        if law.observer is None:
            z = [turned(y, turns) for y, turns in zip(off, law.wraps, strict=True)]
        elif started:
            z = [_row(row, [turned(y, turns) for y, turns in zip(off, law.wraps, strict=True)]) for row in law.observer.start]
        else:
            apart = [turned(y - _row(row, expected), turns) for y, row, turns in zip(off, law.observer.seen, law.wraps, strict=True)]
            rows = zip(expected, law.observer.correction, law.turns, strict=True)
            z = [turned(value + _row(row, apart), turns) for value, row, turns in rows]
        parts = [_row(row, z) for row in table.shapes[which]]
        level = total(part * part for part in parts)
        integral = [Rounded.of(x, exact=True) for x in memory]
        held, calls = before[0], before[2]
        if held < 0 or level.value > table.leave[which]:
            calls = calls + 1 if held < 0 and level.value <= table.take[which] and not started else int(level.value <= table.take[which])
            held = which if calls > table.settle[which] else -1
            if held >= 0:
                integral = [_row(row, z) for row in table.begins[which]]
        wanted = self._wanted(z, integral)
        limits = list(zip(law.low, law.high, strict=True))
        u = [value.clipped(*bounds) for value, bounds in zip(wanted, limits, strict=True)]
        if held < 0:
            u = [Rounded.of(min(max(0.0, low), high)) for low, high in limits]
        return (held, which, calls), [level, *u, *self._followed(z, u), *self._grown(held, integral, wanted, off)]

    def _wanted(self, z: list[Rounded], integral: list[Rounded]) -> list[Rounded]:
        law = self.table.laws[self.which]
        rows = zip(law.rest, law.gains, law.integral_gains, strict=True)
        return [Rounded.of(rest) - _row(row, z) - _row(more, integral) for rest, row, more in rows]

    def _followed(self, z: list[Rounded], u: list[Rounded]) -> list[Rounded]:
        law = self.table.laws[self.which]
        if law.observer is None:
            return z
        pushed = [value - Rounded.of(rest) for value, rest in zip(u, law.rest, strict=True)]
        return [_row(flow, z) + _row(drive, pushed) for flow, drive in zip(law.observer.advance, law.observer.drive, strict=True)]

    def _grown(self, held: int, integral: list[Rounded], wanted: list[Rounded], off: list[Rounded]) -> list[Rounded]:
        law = self.table.laws[self.which]
        if held < 0:
            return integral
        free = [value.clipped(low, high) for value, low, high in zip(wanted, law.low, law.high, strict=True)]
        found = []
        for k, (i, before) in enumerate(zip(law.integrated, integral, strict=True)):
            grows = turned(off[i], law.wraps[i]) * Rounded.of(law.sample)
            beyond = ((wanted[j].value - free[j].value) * law.integral_gains[j][k] * grows.value for j in range(len(free)))
            found.append(before if any(value < 0 for value in beyond) else before + grows)
        return found


def _row(factors: Any, values: list[Rounded]) -> Rounded:
    return total(Rounded.of(factor) * value for factor, value in zip(factors, values, strict=True) if factor)
