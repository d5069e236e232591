"""Test vectors of an output feedback: a memory, a measurement, and what one call makes of them by the formula in 60 digits.

The law's Program takes no part. One call at a time is enough: whatever a call can do wrong shows in its inputs or in the memory
that it leaves.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Any, Final

from mpmath import mp, mpf

from phichain.emit.law.cases.rounding import Rounded, total, turned
from phichain.emit.law.cases.state import as_fraction, share
from phichain.ir.rounded import nearest
from phichain.laws import OutputFeedback

_DIGITS: Final = 60
_SCALES: Final = (Fraction(0), Fraction(1, 512), Fraction(1, 16), Fraction(1, 4), Fraction(1), Fraction(5), Fraction(12))
"""How far from the target measurements lie: on it, within what a linear law is made for, beyond limits, turns away."""

Memory = dict[str, tuple[float, ...]]


@dataclass(frozen=True)
class Call:
    """One call.

    Attributes:
        memory: the memory before it, numbers of the law's type.
        measured: y_meas, likewise.
        expected: u, then the memory that it leaves, rounded once.
        allowed: how far each of them may be off by rounding alone.
    """

    memory: Memory
    measured: tuple[float, ...]
    expected: tuple[float, ...]
    allowed: tuple[float, ...]


def calls(law: OutputFeedback, real: str) -> tuple[Call, ...]:
    """Calls at several distances from the target, two of each, with a memory near to what is measured.

    Args:
        law: the law.
        real: "double" or "float", the type of its C.
    """
    return tuple(_call(law, real, scale, number) for scale in _SCALES for number in (0, 1))


def first_calls(law: OutputFeedback, real: str) -> tuple[Call, ...]:
    """Starts from several measurements, as calls without inputs of which the memory alone is expected."""
    found = []
    for scale in _SCALES[1:5]:
        measured = _measured(law, real, scale, 1)
        with mp.workdps(_DIGITS):
            found.append(_packed({}, measured, [], _started(law, measured), real))
    return tuple(found)


def _call(law: OutputFeedback, real: str, scale: Fraction, number: int) -> Call:
    measured = _measured(law, real, scale, number)
    memory = {
        name: tuple(nearest(real, scale * share(i, number + 2)) for i in range(size)) for name, size in law.memory.items()
    }
    with mp.workdps(_DIGITS):
        u, following = _stepped(law, memory, measured)
        return _packed(memory, measured, u, following, real)


def _measured(law: OutputFeedback, real: str, scale: Fraction, number: int) -> tuple[float, ...]:
    return tuple(nearest(real, Fraction(offset) + scale * share(i, number)) for i, offset in enumerate(law.offsets))


def _packed(memory: Memory, measured: tuple[float, ...], u: list[Rounded], kept: dict[str, list[Rounded]], real: str) -> Call:
    values = [*u, *(value for part in kept.values() for value in part)]
    expected = tuple(nearest(real, as_fraction(value.value)) for value in values)
    return Call(memory, measured, expected, tuple(nearest(real, as_fraction(value.allowed(real))) for value in values))


def _started(law: OutputFeedback, measured: tuple[float, ...]) -> dict[str, list[Rounded]]:
    kept: dict[str, list[Rounded]] = {}
    if law.observer:
        off = [turned(_away(law, measured, i), law.wraps[i]) for i in range(len(measured))]
        kept["expected"] = [_row(row, off) for row in law.observer.start]
    return kept | ({"integral": [Rounded(mpf(0), mpf(0))] * len(law.integrated)} if law.integrated else {})


def _stepped(law: OutputFeedback, memory: Memory, measured: tuple[float, ...]) -> tuple[list[Rounded], dict[str, list[Rounded]]]:
    """The formulas of `OutputFeedback`, line by line."""
    expected, integral = ([Rounded.of(x, exact=True) for x in memory.get(name, ())] for name in ("expected", "integral"))
    off = [_away(law, measured, i) for i in range(len(measured))]
    if law.observer:
        apart = [turned(y - _row(row, expected), turns) for y, row, turns in zip(off, law.observer.seen, law.wraps, strict=True)]
        z = [
            turned(before + _row(row, apart), turns)
            for before, row, turns in zip(expected, law.observer.correction, law.turns, strict=True)
        ]
    else:
        z = [turned(y, turns) for y, turns in zip(off, law.wraps, strict=True)]
    wanted = [
        Rounded.of(rest) - _row(row, z) - _row(more, integral)
        for rest, row, more in zip(law.rest, law.gains, law.integral_gains, strict=True)
    ]
    u = [value.clipped(low, high) for value, low, high in zip(wanted, law.low, law.high, strict=True)]
    kept = {}
    if law.observer:
        pushed = [value - Rounded.of(rest) for value, rest in zip(u, law.rest, strict=True)]
        rows = zip(law.observer.advance, law.observer.drive, strict=True)
        kept["expected"] = [_row(flow, z) + _row(drive, pushed) for flow, drive in rows]
    if law.integrated:
        grown = [turned(off[i], law.wraps[i]) * Rounded.of(law.sample) for i in law.integrated]
        kept["integral"] = [
            before if _winds_up(law, k, grows, wanted, u) else before + grows
            for k, (before, grows) in enumerate(zip(integral, grown, strict=True))
        ]
    return u, kept


def _winds_up(law: OutputFeedback, k: int, grows: Rounded, wanted: list[Rounded], u: list[Rounded]) -> bool:
    pairs = zip(wanted, u, law.integral_gains, strict=True)
    return any((free.value - held.value) * row[k] * grows.value < 0 for free, held, row in pairs)


def _away(law: OutputFeedback, measured: tuple[float, ...], i: int) -> Rounded:
    return Rounded.of(measured[i], exact=True) - Rounded.of(law.offsets[i])



def _row(factors: Any, values: list[Rounded]) -> Rounded:
    return total(Rounded.of(factor) * value for factor, value in zip(factors, values, strict=True))
