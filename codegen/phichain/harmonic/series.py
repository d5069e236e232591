"""Even functions of time as cosine series, and the Jacobi-Anger expansions of trigonometric ones.

For tau = omega t (Watson, Theory of Bessel Functions, 2.22; Abramowitz and Stegun 9.1.44-45)

    cos(z cos tau) = J_0(z) + 2 sum_{n>=1} (-1)^n J_2n(z) cos 2n tau
    sin(z cos tau) = 2 sum_{n>=0} (-1)^n J_{2n+1}(z) cos (2n+1) tau.

Paper A's (18)-(19) are the expansions of cos(z sin tau) and sin(z sin tau), which lack the (-1)^n; in-phase
motion (17) is a cosine and needs those above.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import product
from typing import Any

import sympy


@dataclass(frozen=True)
class CosineSeries:
    """The sum of coefficients[n] cos(n tau)."""

    coefficients: Mapping[int, sympy.Expr]

    def __mul__(self, other: CosineSeries) -> CosineSeries:
        """Multiply by cos m tau cos n tau = (cos (m - n) tau + cos (m + n) tau) / 2."""
        terms: dict[int, list[sympy.Expr]] = {}
        for (m, a), (n, b) in product(self.coefficients.items(), other.coefficients.items()):
            for harmonic in (abs(m - n), m + n):
                terms.setdefault(harmonic, []).append(a * b / 2)
        return CosineSeries({n: sympy.Add(*values) for n, values in sorted(terms.items())})

    def harmonic(self, n: int) -> sympy.Expr:
        """Return the coefficient of cos(n tau)."""
        return self.coefficients.get(n, sympy.S.Zero)


COSINE = CosineSeries({1: sympy.S.One})
"""cos tau."""

SINE_SQUARED = CosineSeries({0: sympy.Rational(1, 2), 2: -sympy.Rational(1, 2)})
"""sin^2 tau."""


def cosine_of(z: Any, order: int) -> CosineSeries:
    """Return cos(z cos tau) up to the harmonic `order`."""
    even = {n: 2 * (-1) ** (n // 2) * sympy.besselj(n, z) for n in range(2, order + 1, 2)}
    return CosineSeries({0: sympy.besselj(0, z)} | even)


def sine_of(z: Any, order: int) -> CosineSeries:
    """Return sin(z cos tau) up to the harmonic `order`."""
    return CosineSeries({n: 2 * (-1) ** (n // 2) * sympy.besselj(n, z) for n in range(1, order + 1, 2)})
