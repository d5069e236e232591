"""Minimum, maximum and whole numbers of Program scalars: all that is not smooth, over two kinds of operation.

`select(a, b, x, y)` is x where a < b and y elsewhere; `floor(x)` is the largest whole number that is not above x. Their
derivatives are those of the branch that is taken, and zero. A comparison with NaN does not hold, so the first argument of
`minimum` and `maximum` passes through as NaN.
"""

from __future__ import annotations

from fractions import Fraction

from phichain.ir.builder import Expr, Number


def minimum(value: Expr, bound: Expr | Number) -> Expr:
    """The smaller of two; NaN where the value is NaN."""
    return value.builder.apply("select", bound, value, bound, value)


def maximum(value: Expr, bound: Expr | Number) -> Expr:
    """The larger of two; NaN where the value is NaN."""
    return value.builder.apply("select", value, bound, bound, value)


def floor(value: Expr) -> Expr:
    """The largest whole number that is not above the value."""
    return value.builder.apply("floor", value)


def wrapped(value: Expr, period: Fraction) -> Expr:
    """The value less a whole number of periods: value - period floor(value / period + 1/2), in [-period/2, period/2)."""
    return value - period * floor((1 / period) * value + Fraction(1, 2))
