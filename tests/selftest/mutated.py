"""Programs with a fault put in, and arithmetic that fuses: what self-tests are tried with."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction
from typing import Any

from phichain.ir.interpret import Algebra
from phichain.ir.nodes import Const, For, Local, Op, Program, Statement, Store
from phichain.ir.rounded import arithmetic, nearest
from phichain.lowering.lower import Lowered


def scaled_outputs(program: Program, factor: Fraction | None) -> Program:
    """The Program with every output multiplied by a factor, or divided by zero."""
    kind, operand = ("div", Const(Fraction(0))) if factor is None else ("mul", Const(factor))
    outputs = {array.name for array in program.outputs}

    def rewritten(statements: tuple[Statement, ...], path: str) -> Iterator[Statement]:
        for number, statement in enumerate(statements):
            here = f"{path}_{number}"
            if isinstance(statement, For):
                yield replace(statement, body=tuple(rewritten(statement.body, here)))
            elif isinstance(statement, Store) and statement.cell.array in outputs:
                yield Op(f"_mutant{here}", kind, (statement.value, operand))
                yield Store(statement.cell, Local(f"_mutant{here}"))
            else:
                yield statement

    return replace(program, body=tuple(rewritten(program.body, "")))


def with_mutant(lowered: Lowered, name: str, factor: Fraction | None) -> Lowered:
    """The scene's Programs, one of them spoilt."""
    return replace(lowered, wanted={**lowered.wanted, name: scaled_outputs(lowered.wanted[name], factor)})


class Fused(float):
    """A rounded product that remembers its factors: the sum that takes it in rounds once for both."""

    exact: Fraction


def fused_arithmetic(real: str) -> Algebra:
    """Correctly rounded arithmetic in which every product that meets a sum is contracted to a fused multiply-add, of two the first."""
    plain = arithmetic(real)

    def apply(kind: str, args: Any, label: str) -> float:
        a, b = (*args, 0.0)[:2]
        if kind == "mul":
            product = Fused(plain.apply(kind, args, label))
            product.exact = Fraction(float(a)) * Fraction(float(b))
            return product
        if kind in ("add", "sub") and (isinstance(a, Fused) or isinstance(b, Fused)):
            left = a.exact if isinstance(a, Fused) else Fraction(float(a))
            right = b.exact if isinstance(b, Fused) and not isinstance(a, Fused) else Fraction(float(b))
            return nearest(real, left + right if kind == "add" else left - right)
        return plain.apply(kind, [float(x) for x in args], label)

    return Algebra(plain.constant, apply)
