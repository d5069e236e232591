"""SymPy expressions as Program operations."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from functools import reduce

import sympy

from phichain.errors import EmissionError
from phichain.ir.builder import Builder, Expr


def from_sympy(builder: Builder, expression: sympy.Expr, values: Mapping[sympy.Symbol, Expr]) -> Expr:
    """Record a SymPy expression of +, *, powers by multiples of 1/2, sin, cos, tanh and besselj of orders 0 to 4.

    Args:
        builder: where the operations go.
        expression: what to record.
        values: the value of every free symbol.
    """

    def visit(node: sympy.Expr) -> Expr:
        if node in values:
            return values[node]
        if node.is_Rational:
            return builder.lift(Fraction(int(node.p), int(node.q)))
        if node.is_Float:
            return builder.lift(Fraction(*map(int, sympy.Rational(node).as_numer_denom())))
        if node.is_Add:
            return reduce(lambda a, b: a + b, map(visit, node.args))
        if node.is_Mul:
            return reduce(lambda a, b: a * b, map(visit, node.args))
        if node.is_Pow:
            return _power(builder, visit(node.base), node.exp)
        if isinstance(node, sympy.sin | sympy.cos | sympy.tanh):
            return builder.apply(type(node).__name__, visit(node.args[0]))
        if isinstance(node, sympy.besselj) and node.order in range(5):
            return builder.apply(f"besselj{int(node.order)}", visit(node.argument))
        raise EmissionError(
            "expression", str(node), "this function has no operation in the Program",
            "use +, *, powers, sin, cos, tanh, sqrt or besselj of orders 0 to 4",
        )  # fmt: skip

    return visit(sympy.sympify(expression))


def _power(builder: Builder, base: Expr, exponent: sympy.Expr) -> Expr:
    """Small powers as products, of square roots for odd multiples of a half."""
    if not exponent.is_Rational or exponent.q > 2:
        raise EmissionError(
            "power", str(exponent), "only powers by multiples of 1/2 are emitted", "rewrite the expression"
        )
    factor = builder.sqrt(base) if exponent.q == 2 else base
    result = reduce(lambda a, b: a * b, [factor] * abs(int(exponent.p)), builder.lift(1))
    return 1 / result if exponent.p < 0 else result
