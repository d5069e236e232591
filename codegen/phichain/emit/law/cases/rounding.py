"""Numbers that know how far rounding may have moved them: what a self-test of a law allows.

Each operation of a type with unit roundoff e leaves x (1 + d), |d| <= e, so errors add as

    a + b: err(a) + err(b) + e |a + b|,        a b: |a| err(b) + |b| err(a) + e |a b|,

to first order (Higham, Accuracy and Stability of Numerical Algorithms, 2002, section 3.3). The values themselves are mpmath's.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Any, Final

from mpmath import mp, mpf

EPSILON: Final = {"double": Fraction(1, 2**53), "float": Fraction(1, 2**24)}
"""Unit roundoff of a type."""


@dataclass(frozen=True)
class Rounded:
    """A number and a bound of its error, in units of the type's roundoff.

    Attributes:
        value: The exact number.
        error: How far rounding may have moved it, divided by the unit roundoff.
    """

    value: Any
    error: Any

    @staticmethod
    def of(number: Any, exact: bool = False) -> Rounded:
        """A constant, rounded once, or a number of the type itself."""
        value = mpf(number)
        return Rounded(value, mpf(0) if exact else abs(value))

    def __add__(self, other: Rounded) -> Rounded:
        total = self.value + other.value
        return Rounded(total, self.error + other.error + abs(total))

    def __neg__(self) -> Rounded:
        return Rounded(-self.value, self.error)

    def __sub__(self, other: Rounded) -> Rounded:
        return self + -other

    def __mul__(self, other: Rounded) -> Rounded:
        product = self.value * other.value
        return Rounded(product, abs(self.value) * other.error + abs(other.value) * self.error + abs(product))

    def turned(self) -> Rounded:
        """Less whole turns: the product 2 pi times their number is rounded twice, the difference once."""
        turns = 2 * mp.pi * mp.nint(self.value / (2 * mp.pi))
        return Rounded(self.value - turns, self.error + 2 * abs(turns) + abs(self.value - turns))

    def clipped(self, low: float, high: float) -> Rounded:
        """Between two limits, each rounded once; a bound moves no further than what it bounds."""
        value = min(max(self.value, mpf(low)), mpf(high))
        return Rounded(value, self.error + (abs(value) if value != self.value else 0))

    def allowed(self, real: str) -> Any:
        """Twice the bound in the units of the value: first order, with room for the order of a sum."""
        unit = EPSILON[real]
        return 2 * self.error * mpf(unit.numerator) / unit.denominator


def turned(away: Rounded, turns: bool) -> Rounded:
    """A deviation, less whole turns where these count as none."""
    return away.turned() if turns else away


def total(terms: Any) -> Rounded:
    """The sum, from the first term to the last."""
    found = Rounded(mpf(0), mpf(0))
    for term in terms:
        found = found + term
    return found
