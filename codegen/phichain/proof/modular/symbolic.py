"""SymPy expressions with their definitions as a list of operations, to be compiled over the field as a Program is.

The walk shares nothing with lowering: each subexpression becomes one operation, in the order in which SymPy holds it, with no
simplification; numbers stay exact.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from fractions import Fraction
from functools import reduce

import sympy

from phichain.errors import DerivationError
from phichain.ir.nodes import Affine, Array, Cell, Const, Local, Op, Operand, Program, Store

Definitions = Iterable[tuple[sympy.Symbol, sympy.Expr]]


def cells(array: Array, symbols: Sequence[sympy.Symbol]) -> dict[sympy.Symbol, Operand]:
    """The operands of symbols that are the entries of an array, in order."""
    return {symbol: Cell(array.name, Affine(i)) for i, symbol in enumerate(symbols)}


def as_program(
    name: str,
    inputs: Sequence[Array],
    known: Mapping[sympy.Symbol, Operand],
    definitions: Definitions,
    outputs: Mapping[str, Sequence[sympy.Expr]],
) -> Program:
    """Write expressions as a Program.

    Args:
        name: what to call it.
        inputs: the arrays that the operands of `known` are cells of.
        known: an operand for every free symbol.
        definitions: further symbols with their expressions, in order.
        outputs: what to compute, by the name of an array each.

    Raises:
        DerivationError: an expression holds what is no rational step, sine, cosine, tanh or ln cosh.
    """
    body = _Body(known)
    for symbol, expression in definitions:
        body.values[symbol] = body.operand(expression)
    arrays = []
    for output, entries in outputs.items():
        arrays.append(Array(output, (len(entries),)))
        for i, entry in enumerate(entries):
            body.statements.append(Store(Cell(output, Affine(i)), body.operand(entry)))
    return Program(name, "", (), tuple(inputs), tuple(arrays), (), {}, tuple(body.statements))


class _Body:
    """The operations so far, and the value of every subexpression."""

    def __init__(self, known: Mapping[sympy.Symbol, Operand]) -> None:
        self.values: dict[sympy.Basic, Operand] = dict(known)
        self.statements: list[Op | Store] = []

    def operand(self, expression: sympy.Basic) -> Operand:
        """The value of an expression."""
        if expression not in self.values:
            self.values[expression] = self._made(expression)
        return self.values[expression]

    def _made(self, expression: sympy.Basic) -> Operand:
        if expression.is_Rational or expression.is_Float:
            ratio = sympy.Rational(expression)
            return Const(Fraction(int(ratio.p), int(ratio.q)))
        if expression.is_Add or expression.is_Mul:
            kind = "add" if expression.is_Add else "mul"
            return reduce(lambda a, b: self._op(kind, a, b), map(self.operand, expression.args))
        if expression.is_Pow and expression.exp.is_Integer:
            factor = self.operand(expression.base)
            power = reduce(lambda a, b: self._op("mul", a, b), [factor] * abs(int(expression.exp)))
            return power if expression.exp > 0 else self._op("div", Const(Fraction(1)), power)
        if expression.is_Pow and abs(expression.exp) == sympy.S.Half:
            root = self._op("sqrt", self.operand(expression.base))
            return root if expression.exp > 0 else self._op("div", Const(Fraction(1)), root)
        if isinstance(expression, sympy.sin | sympy.cos):
            return self._op(type(expression).__name__, self.operand(expression.args[0]))
        if isinstance(expression, sympy.tanh):
            return self._op("tanh", self.operand(expression.args[0]))
        if isinstance(expression, sympy.log) and isinstance(expression.args[0], sympy.cosh):
            return self._op("lncosh", self.operand(expression.args[0].args[0]))
        raise DerivationError(
            "Lagrangian", expression, "has no value in the field", "write it with +, *, whole powers and roots, sin, cos, tanh and ln cosh"
        )

    def _op(self, kind: str, *args: Operand) -> Local:
        result = Local(f"y{len(self.statements)}")
        self.statements.append(Op(result.name, kind, args))
        return result
