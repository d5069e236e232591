r"""Bessel functions J0..J4 of one argument from arithmetic alone: the mathematics of the emitted `bessel`.

Single-harmonic balance (docs/theory.md, section 6) needs J0..J3 and, for its derivatives, J4; neither C99 nor CasADi has
them. Two regions meet at |x| = X, X = 25 in double and 12 in float.

|x| < X: Miller's backward recurrence. With r_k = J_k(x) / (x/2)^k and y = (x/2)^2,

    r_(k-1) = k r_k - y r_(k+1)          (DLMF 10.6.1; no division by x, even in x by structure),
    J0 + 2 (J2 + J4 + ...) = 1           (DLMF 10.12.4; gives the scale),

from r_(M+1) = 0, r_M = 1 with M = s + 2 floor(|x|), s = 18 in double and 8 in float. It is exact at x = 0,
and for small x every J_n keeps its relative accuracy, so that J1(x)/x and its like are good.
Truncation: started so, exact arithmetic delivers J_n - Y_n J_(M+1)/Y_(M+1), and its scale misses
2 (J_(M+2) + J_(M+4) + ...). M lies so far beyond |x| that |J_(M+1)| <= (|x|/2)^(M+1) / (M+1)! (DLMF 10.14.4)
governs both; for each M they grow with |x|, and a test evaluates them at the largest: below 2^-55 in double
and 2^-27 in float.

|x| >= X: Hankel's expansions of J0 and J1 (DLMF 10.17.3), K terms in each of P and Q; each remainder is
smaller than the first term left out (DLMF 10.17(iii)): 5e-18 with K = 9, in float 4e-9 with K = 4. Then
J_(k+1) = 2k/x J_k - J_(k-1), which is stable upwards as long as k < |x|.

Rounding. To first order the error of each operation is carried on by the recurrence itself; the magnitudes,
added up over all operations, give the a-priori bounds `PROVEN`, which a test evaluates over the whole range:
16.5 times half a unit in the last place of 1 in double, 11.8 times in float. Measured against 40 digits the
errors stay below `ERROR`, which the emitted text states. Both are absolute errors of each J_n for every
finite x; the C library's sine and cosine count as correct to one unit in the last place.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from fractions import Fraction
from math import factorial, pi
from typing import Final

ORDERS: Final = 5
"""How many functions are evaluated at once: J0..J4."""

HEADERS: Final = ("math.h",)
"""Headers a translation unit needs before it includes the rendered C template."""


@dataclass(frozen=True)
class Regions:
    """How one format divides the axis.

    Attributes:
        crossover: X; the recurrence serves below, Hankel's expansion from there on.
        start: s; the recurrence starts at the even order M = s + 2 floor(|x|).
        terms: K; number of terms in each of P and Q.
    """

    crossover: int
    start: int
    terms: int

    def order(self, x: float) -> int:
        """Return the order M at which the recurrence starts for the argument x."""
        return self.start + 2 * int(abs(x))


REGIONS: Final = {"double": Regions(25, 18, 9), "float": Regions(12, 8, 4)}
CASADI_START: Final = 60
"""Order at which the recurrence starts in the CasADi text, whatever x: enough for all |x| < X."""

ERROR: Final = {"double": 4e-16, "float": 2e-7}
"""Measured bound of the absolute error of every J_n, any finite x."""
PROVEN: Final = {"double": 2e-15, "float": 8e-7}
"""First-order a-priori bound of the same error."""


def hankel_coefficient(order: int, k: int) -> Fraction:
    """Return a_k(n) = (4n^2 - 1)(4n^2 - 9) ... (4n^2 - (2k-1)^2) / (k! 8^k) exactly, DLMF (10.17.1).

    Args:
        order: n, the order of the Bessel function.
        k: Index of the term.
    """
    product = Fraction(1, factorial(k) * 8**k)
    for odd in range(1, 2 * k, 2):
        product *= 4 * order**2 - odd**2
    return product


def hankel_series(order: int, terms: int) -> tuple[tuple[Fraction, ...], tuple[Fraction, ...]]:
    """Return the coefficients of P and of x Q in powers of 1/x^2 (DLMF 10.17.3), lowest first.

    J_n(x) = sqrt(2/(pi x)) (P cos(w) - Q sin(w)),  w = x - n pi/2 - pi/4.
    """
    alternating = [hankel_coefficient(order, k) * (-1) ** (k // 2) for k in range(2 * terms)]
    return tuple(alternating[0::2]), tuple(alternating[1::2])


def _hankel(terms: int) -> dict[str, tuple[Fraction, ...]]:
    p0, q0 = hankel_series(0, terms)
    p1, q1 = hankel_series(1, terms)
    return {"p0": p0, "q0": q0, "p1": p1, "q1": q1}


def _decimal(value: Fraction | float, real: str) -> str:
    if real == "double":
        return repr(float(value))
    rounded = struct.unpack("f", struct.pack("f", float(value)))[0]
    text = f"{rounded:.9g}"
    return text + ("F" if set(text) & set(".e") else ".0F")


def _horner(values: tuple[Fraction, ...], real: str) -> str:
    text = _decimal(values[-1], real)
    factor = text if values[-1] > 0 else f"({text})"
    for value in reversed(values[:-1]):
        text = f"{_decimal(value, real)} + z * {factor}"
        factor = f"({text})"
    return text


def coefficients(real: str) -> dict[str, object]:
    """Return the finished literals and names that `templates/bessel.c.j2` asks for, beside `name` and `real`.

    Args:
        real: "double" or "float".
    """
    regions = REGIONS[real]
    letter, suffix = ("", "") if real == "double" else ("F", "f")
    series = _hankel(regions.terms)
    numbers = {"zero": 0.0, "half": 0.5, "one": 1.0, "two": 2.0, "three": 3.0, "four": 4.0, "six": 6.0}
    functions = ("fabs", "sqrt", "sin", "cos")
    return {
        "crossover": str(regions.crossover),
        "crossover_literal": f"{regions.crossover}.0{letter}",
        "start": regions.start,
        "error": f"{ERROR[real]:g}",
        "one_over_pi": _decimal(1 / pi, real),
        "hankel": [{"name": name, "text": _horner(values, real)} for name, values in series.items()],
        **{name: f"{value}{letter}" for name, value in numbers.items()},
        **{name: name + suffix for name in functions},
    }


def casadi_coefficients() -> dict[str, object]:
    """Return what `templates/casadi/bessel.py.j2` asks for; its recurrence starts at one fixed order."""
    regions = REGIONS["double"]
    series = _hankel(regions.terms)
    return {
        "crossover": f"{regions.crossover}.0",
        "start": CASADI_START,
        "error": f"{ERROR['double']:g}",
        "hankel": [
            {"name": name, "coefficients": [_decimal(value, "double") for value in values]}
            for name, values in series.items()
        ],
    }
