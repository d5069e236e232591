"""Test vectors of a law: measurements near and far from its target, and its inputs by the formula itself in 60 digits.

The law's Program takes no part: what it is compared with is u = clip(u_0 - K w(x - x_target), low, high) in mpmath.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import isfinite
from typing import Any, Final

from mpmath import mp, mpf

from phichain.errors import EmissionError
from phichain.ir.rounded import nearest
from phichain.laws import StateFeedback

DIGITS: Final = 60
EPSILON: Final = {"double": Fraction(1, 2**53), "float": Fraction(1, 2**24)}
_ROUNDINGS: Final = 4
"""Roundings of one term beside those of the sum: of the numbers of the law, of the deviation, of a whole turn, of the product."""

_SCALES: Final = (Fraction(0), Fraction(1, 512), Fraction(1, 16), Fraction(1, 4), Fraction(1), Fraction(5), Fraction(12))
"""How far from the target measurements lie: on it, within what a linear law is made for, beyond limits, turns away."""

_HALF_TURN: Final = Fraction(25, 8)
"""A little less than pi."""


@dataclass(frozen=True)
class Vector:
    """One measurement and what the law makes of it.

    Attributes:
        measured: x_meas, numbers of the law's type.
        expected: u, rounded once.
        allowed: how far each input may be off by rounding alone.
    """

    measured: tuple[float, ...]
    expected: tuple[float, ...]
    allowed: tuple[float, ...]


def vectors(law: StateFeedback, real: str) -> tuple[Vector, ...]:
    """Measurements at several distances, two of each, and with each angle just within half a turn on either side.

    Args:
        law: the law.
        real: "double" or "float", the type of its C.
    """
    spread = [[scale * share(i, number) for i in range(len(law.target))] for scale in _SCALES for number in (0, 1)]
    turning = [k for k, turns in enumerate(law.wraps) if turns]
    beside = [[side * (i == k) for i in range(len(law.target))] for k in turning for side in (_HALF_TURN, -_HALF_TURN)]
    return tuple(_vector(law, real, away) for away in (*spread, *beside))


def _vector(law: StateFeedback, real: str, away: Sequence[Fraction]) -> Vector:
    measured = tuple(nearest(real, Fraction(target) + part) for target, part in zip(law.target, away, strict=True))
    with mp.workdps(DIGITS):
        found = [_input(law, real, measured, row) for row in range(len(law.gains))]
        expected = tuple(nearest(real, as_fraction(u)) for u, _ in found)
        allowed = tuple(nearest(real, as_fraction(bound)) for _, bound in found)
    return Vector(measured, expected, allowed)


def share(i: int, number: int) -> Fraction:
    """A number between -1 and 1 with few digits, another one for every entry."""
    return Fraction((37 * i + 23 * number + 11) % 64 - 32, 32)


def _input(law: StateFeedback, real: str, measured: tuple[float, ...], row: int) -> tuple[Any, Any]:
    """One input, and what rounding may add to it."""
    u, terms = mpf(law.rest[row]), abs(mpf(law.rest[row]))
    for gain, target, turns, x in zip(law.gains[row], law.target, law.wraps, measured, strict=True):
        away = turned(mpf(x) - mpf(target), turns)
        u -= mpf(gain) * away
        terms += abs(mpf(gain)) * (abs(away) + abs(mpf(x)) + abs(mpf(target)))
    unit = mpf(EPSILON[real].numerator) / EPSILON[real].denominator
    bound = (_ROUNDINGS + len(measured)) * unit * terms
    low, high = law.low[row], law.high[row]
    if isfinite(low):
        u = max(u, mpf(low))
    if isfinite(high):
        u = min(u, mpf(high))
    return u, bound


def turned(away: Any, turns: bool) -> Any:
    """A deviation in 60 digits, less whole turns where these count as none."""
    return away - 2 * mp.pi * mp.nint(away / (2 * mp.pi)) if turns else away


def fitting(real: str, value: float) -> float:
    """The nearest number of a type.

    Raises:
        EmissionError: It does not fit.
    """
    found = nearest(real, Fraction(value))
    if not isfinite(found):
        raise EmissionError("law", value, f"does not fit into a {real}", 'generate it in "double"')
    return found


def as_fraction(value: Any) -> Fraction:
    """An mpf as the fraction that it is."""
    sign, mantissa, exponent, _ = value._mpf_
    whole = -mantissa if sign else mantissa
    return Fraction(int(whole)) * Fraction(2) ** exponent
