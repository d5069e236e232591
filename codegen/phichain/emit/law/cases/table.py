"""Test vectors of a table of gains: states on several levels of every equilibrium, and what supervisor and law make of them.

The Programs take no part: levels and inputs are the formulas of `GainTable` in 60 digits. States lie on levels clear of 1 and of the
level at which an equilibrium is let go, so that rounding decides nothing.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Any, Final

import numpy as np
from mpmath import mp

from phichain.emit.law.cases.rounding import Rounded, total, turned
from phichain.emit.law.cases.state import as_fraction, share
from phichain.ir.rounded import nearest
from phichain.laws import GainTable

_DIGITS: Final = 60
_INSIDE, _BETWEEN, _NEARLY, _OUTSIDE = 0.25, 0.5, 0.9, 1.5
"""Levels of the cases: well within, between 1 and `leave` (as a share of the way), short of it and beyond it
(as multiples)."""


@dataclass(frozen=True)
class Case:
    """One call.

    Attributes:
        before: which equilibrium is held, -1 for none.
        after: which is held then.
        measured: x_meas, numbers of the table's type.
        expected: the level that decided, then u, rounded once.
        allowed: how far each of them may be off by rounding alone.
    """

    before: int
    after: int
    measured: tuple[float, ...]
    expected: tuple[float, ...]
    allowed: tuple[float, ...]


def cases(table: GainTable, real: str) -> tuple[Case, ...]:
    """Each equilibrium taken up, held between the levels, not taken up there, and let go.

    Args:
        table: the table.
        real: "double" or "float", the type of its C.
    """
    found = []
    for which in range(len(table.signs)):
        between = 1 + _BETWEEN * (table.leave - 1)
        found.append(_case(table, real, which, -1, _INSIDE, which))
        found.append(_case(table, real, which, -1, _OUTSIDE * table.leave, -1))
        found.append(_case(table, real, which, which, _OUTSIDE * table.leave, -1))
        if between > 1.01:
            found.append(_case(table, real, which, which, between, which))
            found.append(_case(table, real, which, -1, between, -1))
            found += [_case(table, real, which, which, _NEARLY * table.leave, which, side) for side in (1, -1)]
    return tuple(found)


def _case(table: GainTable, real: str, which: int, before: int, level: float, after: int, side: int = 0) -> Case:
    measured = _state(table, real, which, level, side)
    with mp.workdps(_DIGITS):
        decided = _level(table, which, measured)
        inputs = _inputs(table, after, measured)
        values = [decided, *inputs]
        expected = tuple(nearest(real, as_fraction(value.value)) for value in values)
        return Case(before, after, measured, expected, tuple(nearest(real, as_fraction(value.allowed(real))) for value in values))


def _state(table: GainTable, real: str, which: int, level: float, side: int) -> tuple[float, ...]:
    """A state near a level, along a direction of its own for each equilibrium, or the one that drives the first input hardest to a side.

    The level of what is rounded is what is expected of it.
    """
    shape = np.array(table.shapes[which])
    away = np.linalg.lstsq(shape, np.array([float(share(i, which)) + 0.01 for i in range(len(shape))]), rcond=None)[0]
    if side:
        away = side * np.linalg.pinv(shape.T @ shape) @ np.array(table.gains[which][0])
    away *= np.sqrt(level / np.sum((shape @ away) ** 2))
    targets = table.targets[which]
    return tuple(nearest(real, Fraction(target) + Fraction(float(part))) for target, part in zip(targets, away, strict=True))


def _away(table: GainTable, which: int, measured: tuple[float, ...]) -> list[Rounded]:
    found = []
    for x, target, turns in zip(measured, table.targets[which], table.wraps, strict=True):
        away = Rounded.of(x, exact=True) - Rounded.of(target)
        found.append(turned(away, turns))
    return found


def _level(table: GainTable, which: int, measured: tuple[float, ...]) -> Rounded:
    away = _away(table, which, measured)
    parts = [total(Rounded.of(w) * d for w, d in zip(row, away, strict=True) if w) for row in table.shapes[which]]
    return total(part * part for part in parts)


def _inputs(table: GainTable, which: int, measured: tuple[float, ...]) -> list[Any]:
    if which < 0:
        return [Rounded.of(min(max(0.0, low), high)) for low, high in zip(table.low, table.high, strict=True)]
    away = _away(table, which, measured)
    found = []
    for rest, row, low, high in zip(table.rest[which], table.gains[which], table.low, table.high, strict=True):
        u = Rounded.of(rest)
        for gain, d in zip(row, away, strict=True):
            u = u - Rounded.of(gain) * d if gain else u
        found.append(u.clipped(low, high))
    return found


