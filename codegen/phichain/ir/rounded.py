"""Arithmetic of the two types on any processor: numbers rounded once, and Programs run with every operation rounded once.

IEEE 754 fixes +, -, *, / and the square root to the last bit, so Python's floats give the same on every machine. A result of
two binary32 numbers is rounded in binary64 and then to binary32, which is as good as once: 53 >= 2 * 24 + 2 (Figueroa 1995).
Sines, cosines, tanh and Bessel functions come from mpmath with twice the digits. Nothing here asks NumPy or the C library's libm,
whose last bits depend on the processor and the release.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Callable, Mapping
from fractions import Fraction
from functools import partial
from typing import Any, Final

from mpmath import mp, mpf

from phichain.ir.interpret import Algebra

#: Distance from 1 to the next number of the type.
EPSILON: Final[Mapping[str, float]] = {"double": 1 / 2**52, "float": 1 / 2**23}

_LARGEST_BINARY32: Final = float(2**128 - 2**104)
_TRANSCENDENTAL_BITS: Final = 128
_BINARY32: Final = struct.Struct("<f")


def nearest(real: str, value: Any) -> float:
    """The number of a type nearest to an exact one, ties to even; infinite beyond the range.

    Args:
        real: "double" or "float".
        value: an int, a float, a Fraction or an mpf, taken as exactly what it is.
    """
    if isinstance(value, float):
        return value if real == "double" else _binary32(value)
    if isinstance(value, mpf):
        if not mp.isfinite(value):
            return _special(value)
        value = _fraction(value)
    try:
        number = float(value.numerator / value.denominator)  # of integers: rounded once
    except OverflowError:
        number = math.inf if value > 0 else -math.inf
    return number if real == "double" else _once_more(number, value)


def _fraction(value: Any) -> Fraction:
    sign, mantissa, exponent, _ = value._mpf_
    whole = -int(mantissa) if sign else int(mantissa)
    return Fraction(whole << exponent) if exponent >= 0 else Fraction(whole, 1 << -exponent)


def _once_more(number: float, value: Any) -> float:
    """The nearest binary64 rounded to binary32; where it lies half-way between two of those, the exact value decides."""
    single = _binary32(number)
    if math.isinf(single):
        half_way, other = float(2**128 - 2**103), math.copysign(_LARGEST_BINARY32, number)
        return other if abs(number) == half_way and abs(value) < Fraction(half_way) else single
    other = single + 2.0 * (number - single)
    if other == single or _binary32(other) != other:
        return single
    return min((single, other), key=lambda x: abs(Fraction(x) - value)) if value != Fraction(number) else single


def _special(value: Any) -> float:
    """An infinity or NaN of mpmath as a float."""
    if mp.isnan(value):
        return math.nan
    return math.inf if value > 0 else -math.inf


def _binary32(value: float) -> float:
    try:
        (number,) = _BINARY32.unpack(_BINARY32.pack(value))
    except OverflowError:
        return math.copysign(math.inf, value)
    return float(number)


def arithmetic(real: str) -> Algebra:
    """The algebra that runs a Program on Python floats as correctly rounded C of the type would, without contraction.

    Constants beyond the range become infinite; a division by zero and the root of a negative number give what IEEE 754 says.
    """

    def apply(kind: str, args: Any, label: str) -> float:
        operation = _OPERATIONS.get(kind)
        if operation is None:
            return _transcendental(real, kind, args[0])
        result = operation(*args)
        return result if real == "double" else _binary32(result)

    return Algebra(lambda value: nearest(real, value), apply)


def _divided(a: float, b: float) -> float:
    if b:
        return a / b
    if not a or math.isnan(a):
        return math.nan
    return math.copysign(math.inf, a) * math.copysign(1.0, b)


def _root(a: float) -> float:
    return math.sqrt(a) if a >= 0.0 else math.nan


def _floor(a: float) -> float:
    return math.copysign(float(math.floor(a)), a) if math.isfinite(a) else a


_OPERATIONS: Final[Mapping[str, Callable[..., float]]] = {
    "add": lambda a, b: a + b, "sub": lambda a, b: a - b, "mul": lambda a, b: a * b, "div": _divided,
    "neg": lambda a: -a, "sqrt": _root, "select": lambda a, b, x, y: x if a < b else y, "floor": _floor,
}  # fmt: skip

_FUNCTIONS: Final[Mapping[str, Callable[[Any], Any]]] = {
    "sin": mp.sin, "cos": mp.cos, "tanh": mp.tanh, **{f"besselj{n}": partial(mp.besselj, n) for n in range(5)},
}  # fmt: skip


def _transcendental(real: str, kind: str, x: float) -> float:
    if not math.isfinite(x):
        return math.nan
    with mp.workprec(_TRANSCENDENTAL_BITS):
        return nearest(real, _FUNCTIONS[kind](mpf(x)))
