"""Values of SymPy expressions in the field of integers modulo the prime 2^61 - 1, for comparing expressions exactly.

Two polynomials that differ agree at a random point with a probability below degree / 2^61 (Schwartz, Zippel). An angle is
a pair: its value, and a point of the circle ((1 - t^2)/(1 + t^2), 2 t/(1 + t^2)) that adds as angles add; the two are
algebraically independent, as an angle and its sine are.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from random import Random
from typing import Final

import sympy

from phichain.errors import DerivationError

PRIME: Final = 2**61 - 1
"""The modulus, a Mersenne prime congruent to 3 modulo 4."""

Circle = tuple[int, int]
"""Cosine and sine of an angle."""


@dataclass(frozen=True)
class Angle:
    """An angle: its value, and its point of the circle."""

    value: int
    circle: Circle

    def __add__(self, other: Angle) -> Angle:
        return Angle((self.value + other.value) % PRIME, _turned(self.circle, other.circle))


class Residues:
    """A random point: every symbol has a value, drawn when it is first met unless a definition gave one."""

    def __init__(self, source: Random) -> None:
        self._source = source
        self._values: dict[sympy.Symbol, int] = {}
        self._circles: dict[sympy.Symbol, Circle] = {}
        self._defined: set[sympy.Symbol] = set()
        self._log_cosh: dict[int, int] = {}
        self._roots: dict[int, int] = {}

    def define(self, definitions: Iterable[tuple[sympy.Symbol, sympy.Expr]]) -> None:
        """Give symbols the values of their definitions, one after the other.

        Raises:
            DerivationError: A definition is no rational function of symbols and of sines and cosines of angles.
        """
        for symbol, expression in definitions:
            self._values[symbol] = self.value(expression)
            self._defined.add(symbol)
            circle = self._circle(expression)
            if circle is not None:
                self._circles[symbol] = circle

    def value(self, expression: sympy.Expr) -> int:
        """Return the value of an expression.

        Raises:
            DerivationError: It is no rational function of symbols, of sines and cosines of angles, of roots and of ln cosh.
        """
        if isinstance(expression, sympy.Symbol):
            if expression not in self._values:
                self._values[expression] = self._source.randrange(1, PRIME)
            return self._values[expression]
        if isinstance(expression, (sympy.Rational, sympy.Float)):
            exact = sympy.Rational(expression)
            return int(exact.p) * inverse(int(exact.q)) % PRIME
        if isinstance(expression, sympy.Add):
            return sum(map(self.value, expression.args)) % PRIME
        if isinstance(expression, sympy.Mul):
            product = 1
            for factor in expression.args:
                product = product * self.value(factor) % PRIME
            return product
        if isinstance(expression, sympy.Pow) and expression.exp.is_Integer:
            return pow(self.value(expression.base), int(expression.exp), PRIME)
        if isinstance(expression, sympy.Pow) and expression.exp == sympy.S.Half:
            return self.root(self.value(expression.base))
        if isinstance(expression, (sympy.sin, sympy.cos)):
            circle = self._circle(expression.args[0])
            if circle is not None:
                return circle[isinstance(expression, sympy.sin)]
        if isinstance(expression, sympy.log) and isinstance(expression.args[0], sympy.cosh):
            return self.log_cosh(self.value(expression.args[0].args[0]))
        raise DerivationError(
            "Lagrangian", expression, "holds what is no rational function of symbols and of sines of sums of angles",
            "write it in symbols with definitions",
        )  # fmt: skip

    def log_cosh(self, x: int) -> int:
        """Return ln cosh(x): a value of its own for every x and its opposite, zero at zero."""
        even = min(x % PRIME, -x % PRIME)
        if even not in self._log_cosh:
            self._log_cosh[even] = self._source.randrange(1, PRIME) if even else 0
        return self._log_cosh[even]

    def root(self, square: int) -> int:
        """Return what stands for the root of a value: one of its own for every value, as half of them have none."""
        if square % PRIME not in self._roots:
            self._roots[square % PRIME] = self._source.randrange(1, PRIME)
        return self._roots[square % PRIME]

    def angle(self, symbol: sympy.Symbol) -> Angle:
        """Return the angle that a symbol without a definition stands for."""
        return Angle(self.value(symbol), self._point(symbol) or (1, 0))

    def _circle(self, angle: sympy.Expr) -> Circle | None:
        """The point of a sum of whole multiples of angles; None for anything else."""
        found = (1, 0)
        for term in sympy.Add.make_args(angle):
            times, symbol = term.as_coeff_Mul()
            point = self._point(symbol) if times.is_Integer and isinstance(symbol, sympy.Symbol) else None
            if point is None:
                return None
            for _ in range(abs(int(times))):
                found = _turned(found, point if times > 0 else (point[0], -point[1]))
        return found

    def _point(self, symbol: sympy.Symbol) -> Circle | None:
        """The point of an angle; None where the symbol is defined as something else than a sum of angles."""
        if symbol not in self._circles and symbol not in self._defined:
            t = self._source.randrange(1, PRIME)
            share = inverse(1 + t * t)
            self._circles[symbol] = ((1 - t * t) * share % PRIME, 2 * t * share % PRIME)
        return self._circles.get(symbol)


def _turned(a: Circle, b: Circle) -> Circle:
    """The point of the sum of two angles."""
    return (a[0] * b[0] - a[1] * b[1]) % PRIME, (a[1] * b[0] + a[0] * b[1]) % PRIME


def inverse(value: int) -> int:
    """Return 1 / value modulo the prime.

    Raises:
        ZeroDivisionError: The value is zero there.
    """
    if value % PRIME == 0:
        raise ZeroDivisionError("a division by zero")
    return pow(value, -1, PRIME)
