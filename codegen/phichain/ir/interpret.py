"""Runs a Program over any algebra: numbers, arrays of numbers, 50-digit numbers, symbols, or the operations themselves.

This one walk is what every consumer of a Program shares: the oracle (`evaluate`), unrolling (`passes.unroll`) and the
CasADi backend differ only in the algebra they bring.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from phichain.ir.nodes import Call, Cell, Const, For, Local, Op, Operand, Program, SinCos, Statement, Store

Scalar = Any


@dataclass(frozen=True)
class Algebra:
    """What a Program needs to run.

    Attributes:
        constant: makes a scalar of an exact number.
        apply: ``apply(kind, args, label)`` computes one operation; the label is the operation's name with its indices.
    """

    constant: Callable[[Fraction], Scalar]
    apply: Callable[[str, Sequence[Scalar], str], Scalar]


def run(program: Program, algebra: Algebra, arguments: Mapping[str, Sequence[Scalar]]) -> dict[str, list[Scalar]]:
    """Run a Program.

    Args:
        program: what to run.
        algebra: the scalars to run it on.
        arguments: flat values of every parameter and input array (a scalar argument is a sequence of one).

    Returns:
        Flat values of every output array, by name.
    """
    state = _State(algebra, program, {name: dict(enumerate(values)) for name, values in arguments.items()})
    state.execute(program.body)
    return {
        array.name: [state.arrays[array.name][i] for i in range(array.size)] for array in program.outputs
    }


class _State:
    """Arrays, local values and loop indices while a Program runs."""

    def __init__(self, algebra: Algebra, program: Program, arrays: dict[str, dict[int, Scalar]]) -> None:
        self.algebra, self.program, self.arrays = algebra, program, arrays
        self.locals: dict[str, Scalar] = {}
        self.indices: dict[str, int] = {}
        for name, values in program.tables.items():
            arrays[name] = {i: algebra.constant(value) for i, value in enumerate(values)}
        for array in (*program.outputs, *program.work):
            arrays[array.name] = {}

    def value(self, operand: Operand) -> Scalar:
        if isinstance(operand, Local):
            return self.locals[operand.name]
        if isinstance(operand, Const):
            return self.algebra.constant(operand.value)
        return self.arrays[operand.array][operand.index.at(self.indices)]

    def execute(self, statements: Sequence[Statement]) -> None:
        for statement in statements:
            match statement:
                case Op(result, kind, args):
                    self.locals[result] = self.algebra.apply(kind, [self.value(a) for a in args], self.label(result))
                case Store(Cell(array, index), value):
                    self.arrays[array][index.at(self.indices)] = self.value(value)
                case SinCos():
                    self.sincos(statement)
                case For():
                    self.loop(statement)
                case Call():
                    self.call(statement)

    def label(self, name: str) -> str:
        """A named value's name in this turn of the loops: `rate_k` and `rate` alike become `rate_3`."""
        if name.startswith("_"):
            return ""
        stem = name.removesuffix("".join(f"_{variable}" for variable in self.indices))
        return "_".join([stem, *(str(i) for i in self.indices.values())])

    def sincos(self, statement: SinCos) -> None:
        for i in range(statement.count):
            angle = self.arrays[statement.angle][statement.offset + i]
            self.arrays[statement.sine][i] = self.algebra.apply("sin", [angle], f"{statement.sine}_{i}")
            self.arrays[statement.cosine][i] = self.algebra.apply("cos", [angle], f"{statement.cosine}_{i}")

    def loop(self, loop: For) -> None:
        for carry in loop.carries:
            self.locals[carry.name] = self.value(carry.initial)
        for index in loop.range(self.indices):
            self.indices[loop.variable] = index
            self.execute(loop.body)
            following = [self.value(carry.following) for carry in loop.carries]
            self.locals.update(zip((carry.name for carry in loop.carries), following, strict=True))
        self.indices.pop(loop.variable, None)

    def call(self, statement: Call) -> None:
        callee = self.program.callees[statement.callee]
        arguments = {array.name: self._flat(array.name) for array in callee.params}
        for array, name in zip(callee.inputs, statement.inputs, strict=True):
            arguments[array.name] = self._flat(name)
        outputs = run(callee, self.algebra, arguments)
        for array, name in zip(callee.outputs, statement.outputs, strict=True):
            self.arrays[name] = dict(enumerate(outputs[array.name]))

    def _flat(self, name: str) -> list[Scalar]:
        cells = self.arrays[name]
        return [cells[i] for i in range(len(cells))]
