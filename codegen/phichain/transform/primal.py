"""The original inside a derivative of loops: copied once, each of its values where a derivative finds it later."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from phichain.errors import EmissionError
from phichain.ir.builder import ArrayRef, Builder, Expr
from phichain.ir.nodes import Affine, Call, Cell, Const, For, Op, Operand, Program, SinCos, Statement, Store


@dataclass(frozen=True)
class _Kept:
    """Where a value of the original is found later: one cell a turn of the loops around it."""

    array: ArrayRef
    position: Affine
    loops: tuple[For, ...]

    def within(self, loops: Sequence[For]) -> bool:
        """Whether all its loops are among these; loops of one variable are told apart."""
        return all(any(loop is other for other in loops) for loop in self.loops)


class Primal:
    """Copies the original into the builder and remembers where each of its values can be read later."""

    def __init__(self, builder: Builder, program: Program, keep_outputs: bool) -> None:
        self.builder, self.program = builder, program
        self.arrays: dict[str, ArrayRef] = {}
        for array in (*program.params, *program.inputs):
            self.arrays[array.name] = ArrayRef(builder, array.name, array.size)
        for name, values in program.tables.items():
            self.arrays[name] = builder.table(name, len(values), lambda k, values=values: values[k])  # type: ignore[misc]
        for array in program.work:
            self.arrays[array.name] = builder.array(array.name, array.size)
        for array in program.outputs:
            if keep_outputs:
                self.arrays[array.name] = ArrayRef(builder, array.name, array.size)
            else:
                self.arrays[array.name] = builder.array(f"{array.name}_value", array.size)
        self.values: dict[str, Expr] = {}
        self.kept: dict[str, _Kept] = {}
        self.final: dict[str, _Kept] = {}
        self.loops: list[tuple[For, Affine]] = []
        self.indices: dict[str, Affine] = {}

    def copy(self, statements: Sequence[Statement]) -> None:
        for statement in statements:
            match statement:
                case Op(result, kind, args):
                    value = self.builder.apply(kind, *(self.read(arg) for arg in args), label=_label(result))
                    self.define(result, value)
                case Store(cell, value):
                    self.arrays[cell.array][self.index(cell.index)] = self.read(value)
                case SinCos(sine, cosine, angle, offset, count):
                    self.builder.sincos_into(
                        self.arrays[sine], self.arrays[cosine], self.arrays[angle].shifted(offset), count
                    )
                case For():
                    self.copy_loop(statement)
                case Call(callee):
                    raise EmissionError(
                        "tangent", callee, "a loop Program that calls another has no derivative",
                        "differentiate the callee, or unroll first",
                    )  # fmt: skip

    def copy_loop(self, loop: For) -> None:
        with self.builder.loop(loop.variable, self.index(loop.start), self.index(loop.stop), loop.step) as copied:
            self.indices[loop.variable] = copied.index
            self.loops.append((loop, copied.index))
            carried = {c.name: copied.carry(c.name, self.read(c.initial)) for c in loop.carries}
            for name, value in carried.items():
                self.define(name, value)
            self.copy(loop.body)
            for carry in loop.carries:
                copied.follow(carried[carry.name], self.read(carry.following))
            self.loops.pop()
            del self.indices[loop.variable]
        self.values.update(carried)
        if self.loops:
            self.final |= {name: self.keep(name, value) for name, value in carried.items()}

    def define(self, name: str, value: Expr) -> None:
        """Remember a value; inside loops also keep it in an array, one cell a turn (pruned when unused)."""
        self.values[name] = value
        if self.loops and not isinstance(value.operand, Const | Cell):
            self.kept[name] = self.keep(name, value)

    def keep(self, name: str, value: Expr) -> _Kept:
        """Store a value in an array, one cell a turn of the loops that are open."""
        size, position = 1, Affine()
        for loop, _ in self.loops:
            low, high = loop.hull
            extent = max(high - low + 1, 1)
            position = position * extent + (Affine(0, ((loop.variable, 1),)) - low)
            size *= extent
        kept = self.builder.array(f"{_label(name) or 'kept'}_at", size)
        kept[substitute(position, self.indices)] = value
        return _Kept(kept, position, tuple(loop for loop, _ in self.loops))

    def index(self, index: Affine) -> Affine:
        return substitute(index, self.indices)

    def read(self, operand: Operand) -> Expr:
        if isinstance(operand, Const):
            return Expr(self.builder, operand)
        if isinstance(operand, Cell):
            return self.arrays[operand.array][self.index(operand.index)]
        return self.values[operand.name]


def substitute(index: Affine, indices: dict[str, Affine]) -> Affine:
    """An index with other variables put in."""
    result = Affine(index.offset)
    for variable, coefficient in index.terms:
        result = result + indices.get(variable, Affine(0, ((variable, 1),))) * coefficient
    return result


def _label(name: str) -> str:
    return "" if name.startswith("_") else name
