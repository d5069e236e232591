"""Exact simplification of one operation: the rules that every pass shares.

Only rules that hold for finite numbers and drop structural zeros are applied; nothing is reassociated except products of
constants. A factor that is structurally zero removes the product, so NaN passes through every term that exists.
"""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from math import floor

from phichain.ir.nodes import Const, Op, Operand

ZERO, ONE, MINUS_ONE = Const(Fraction(0)), Const(Fraction(1)), Const(Fraction(-1))

#: Finds the operation behind a local value, so that rules can look through a negation or a product.
Definition = Callable[[Operand], Op | None]
#: Emits (or finds) an operation and returns its value.
Emit = Callable[[str, tuple[Operand, ...]], Operand]


def simplify(kind: str, args: tuple[Operand, ...], definition: Definition, emit: Emit) -> Operand | None:
    """The simpler value of ``kind(*args)``, or None when the operation has to stand as it is."""
    rule = _RULES.get(kind)
    return rule(args, definition, emit) if rule else None


def _negated(operand: Operand, definition: Definition) -> Operand | None:
    """x when the operand is -x (a negative constant counts), else None."""
    if isinstance(operand, Const):
        return Const(-operand.value) if operand.value < 0 else None
    op = definition(operand)
    return op.args[0] if op is not None and op.kind == "neg" else None


def _add(args: tuple[Operand, ...], definition: Definition, emit: Emit) -> Operand | None:
    a, b = args
    if isinstance(a, Const) and isinstance(b, Const):
        return Const(a.value + b.value)
    if a == ZERO:
        return b
    if b == ZERO:
        return a
    if (minus_b := _negated(b, definition)) is not None:
        return emit("sub", (a, minus_b))
    if (minus_a := _negated(a, definition)) is not None:
        return emit("sub", (b, minus_a))
    return None


def _sub(args: tuple[Operand, ...], definition: Definition, emit: Emit) -> Operand | None:
    a, b = args
    if isinstance(a, Const) and isinstance(b, Const):
        return Const(a.value - b.value)
    if b == ZERO:
        return a
    if a == ZERO:
        return emit("neg", (b,))
    if a == b:
        return ZERO
    if (minus_b := _negated(b, definition)) is not None:
        return emit("add", (a, minus_b))
    if not isinstance(a, Const) and (minus_a := _negated(a, definition)) is not None:
        return emit("neg", (emit("add", (minus_a, b)),))
    return None


def _mul(args: tuple[Operand, ...], definition: Definition, emit: Emit) -> Operand | None:
    a, b = args
    if isinstance(b, Const) and not isinstance(a, Const):
        a, b = b, a
    if isinstance(a, Const):
        if isinstance(b, Const):
            return Const(a.value * b.value)
        if a == ZERO:
            return ZERO
        if a == ONE:
            return b
        if a == MINUS_ONE:
            return emit("neg", (b,))
        inner = definition(b)
        if inner is not None and inner.kind == "mul" and isinstance(inner.args[0], Const):
            return emit("mul", (Const(a.value * inner.args[0].value), inner.args[1]))
        if inner is not None and inner.kind == "neg":
            return emit("mul", (Const(-a.value), inner.args[0]))
        return None
    minus_a, minus_b = _negated(a, definition), _negated(b, definition)
    if minus_a is not None and minus_b is not None:
        return emit("mul", (minus_a, minus_b))
    if minus_a is not None:
        return emit("neg", (emit("mul", (minus_a, b)),))
    if minus_b is not None:
        return emit("neg", (emit("mul", (a, minus_b)),))
    return None


def _div(args: tuple[Operand, ...], definition: Definition, emit: Emit) -> Operand | None:
    a, b = args
    if isinstance(b, Const) and b.value:
        return emit("mul", (Const(1 / b.value), a))
    if a == ZERO:
        return ZERO
    if (minus_a := _negated(a, definition)) is not None and not isinstance(a, Const):
        return emit("neg", (emit("div", (minus_a, b)),))
    return None


def _neg(args: tuple[Operand, ...], definition: Definition, emit: Emit) -> Operand | None:
    (a,) = args
    if isinstance(a, Const):
        return Const(-a.value)
    op = definition(a)
    if op is None:
        return None
    if op.kind == "neg":
        return op.args[0]
    if op.kind == "sub":
        return emit("sub", (op.args[1], op.args[0]))
    if op.kind == "mul" and isinstance(op.args[0], Const):
        return emit("mul", (Const(-op.args[0].value), op.args[1]))
    return None


def _sqrt(args: tuple[Operand, ...], definition: Definition, emit: Emit) -> Operand | None:
    return args[0] if args[0] in (ZERO, ONE) else None


def _sin(args: tuple[Operand, ...], definition: Definition, emit: Emit) -> Operand | None:
    return ZERO if args[0] == ZERO else None


def _cos(args: tuple[Operand, ...], definition: Definition, emit: Emit) -> Operand | None:
    return ONE if args[0] == ZERO else None


def _select(args: tuple[Operand, ...], definition: Definition, emit: Emit) -> Operand | None:
    a, b, below, above = args
    if isinstance(a, Const) and isinstance(b, Const):
        return below if a.value < b.value else above
    return below if below == above else None


def _floor(args: tuple[Operand, ...], definition: Definition, emit: Emit) -> Operand | None:
    return Const(Fraction(floor(args[0].value))) if isinstance(args[0], Const) else None


_RULES: dict[str, Callable[[tuple[Operand, ...], Definition, Emit], Operand | None]] = {
    "add": _add, "sub": _sub, "mul": _mul, "div": _div, "neg": _neg, "sqrt": _sqrt, "sin": _sin, "cos": _cos,
    "tanh": _sin,
    "select": _select, "floor": _floor,
    "besselj0": _cos, "besselj1": _sin, "besselj2": _sin, "besselj3": _sin, "besselj4": _sin,
}  # fmt: skip

COMMUTATIVE = frozenset({"add", "mul"})


def canonical(kind: str, args: tuple[Operand, ...]) -> tuple[Operand, ...] | frozenset[Operand]:
    """Arguments without their order where the operation commutes, so that equal values are found again."""
    return frozenset(args) if kind in COMMUTATIVE else args
