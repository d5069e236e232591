"""Jacobians of Programs with loops: the original once, then its derivative along one direction a turn of one more loop.

The derivative of a statement stands where the statement stood. What it needs of the original's loop bodies is kept in work
arrays, one cell a turn; what does not depend on the argument is left out (activity).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from phichain.errors import EmissionError
from phichain.ir.builder import ArrayRef, Builder, Expr
from phichain.ir.nodes import (
    Affine,
    Call,
    Cell,
    Const,
    For,
    Local,
    Op,
    Operand,
    Program,
    SinCos,
    Statement,
    Store,
)
from phichain.transform.blocks import Block
from phichain.transform.derivatives import directional


def loop_jacobian(builder: Builder, program: Program, blocks: Sequence[Block], keep_outputs: bool) -> Program:
    """Fill `builder`, whose arguments are declared, with the Jacobians of `program`."""
    primal = _Primal(builder, program, keep_outputs)
    primal.copy(program.body)
    sizes = {array.name: array.size for array in (*program.params, *program.inputs)}
    for argument in dict.fromkeys(block.argument for block in blocks):
        mine = [block for block in blocks if block.argument == argument]
        with builder.loop("seed", 0, sizes[argument]) as seeds:
            _Tangent(builder, program, primal, argument, sizes[argument], seeds.index, mine).walk(program.body)
    return builder.finish()


def loop_direction(builder: Builder, program: Program, moving: Sequence[str], results: Sequence[str]) -> Program:
    """Fill `builder`, whose arguments are declared, with the derivatives of `results` along how arguments move."""
    primal = _Primal(builder, program, False)
    primal.copy(program.body)
    _Direction(builder, program, primal, moving, results).walk(program.body)
    return builder.finish()


@dataclass(frozen=True)
class _Kept:
    """Where a value of the original is found later: one cell a turn of the loops around it."""

    array: ArrayRef
    position: Affine
    loops: tuple[For, ...]

    def within(self, loops: Sequence[For]) -> bool:
        """Whether all its loops are among these; loops of one variable are told apart."""
        return all(any(loop is other for other in loops) for loop in self.loops)


class _Primal:
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
        kept[_substitute(position, self.indices)] = value
        return _Kept(kept, position, tuple(loop for loop, _ in self.loops))

    def index(self, index: Affine) -> Affine:
        return _substitute(index, self.indices)

    def read(self, operand: Operand) -> Expr:
        if isinstance(operand, Const):
            return Expr(self.builder, operand)
        if isinstance(operand, Cell):
            return self.arrays[operand.array][self.index(operand.index)]
        return self.values[operand.name]


class _Tangent:
    """Writes the derivative along one unit direction of one argument."""

    def __init__(
        self, builder: Builder, program: Program, primal: _Primal, argument: str, size: int, seed: Affine,
        blocks: Sequence[Block],
    ) -> None:  # fmt: skip
        self.seed = seed
        self.blocks, self.size = {block.output: block for block in blocks}, size
        self.begin(builder, program, primal, (argument,))
        # one_hot[size - 1 + i - seed] is 1 at i = seed and 0 elsewhere
        one_hot = builder.table(f"one_hot_{size}", 2 * size - 1, lambda i: int(i == size - 1))
        self.arrays[argument] = one_hot.shifted(size - 1 - seed)

    def begin(self, builder: Builder, program: Program, primal: _Primal, arguments: Sequence[str]) -> None:
        """Nothing is written yet."""
        self.builder, self.program, self.primal = builder, program, primal
        self.active = _active(program, arguments)
        self.indices: dict[str, Affine] = {}
        self.inside: list[For] = []
        self.slopes: dict[str, Expr] = {}
        self.arrays: dict[str, ArrayRef] = {}
        for array in program.work:
            if array.name in self.active:
                self.arrays[array.name] = builder.array(f"d_{array.name}", array.size)

    def walk(self, statements: Sequence[Statement]) -> None:
        for statement in statements:
            match statement:
                case Op(result, kind, args):
                    if result in self.active:
                        values = [self.value(arg) for arg in args]
                        slopes = [self.slope(arg) for arg in args]
                        slope = directional(self.builder, kind, values, self.value(Local(result)), slopes)
                        if slope is not None:
                            self.slopes[result] = slope
                case Store(cell, value):
                    self.store(cell, value)
                case SinCos(sine, cosine, angle, offset, count):
                    if angle in self.active:
                        self.sincos(sine, cosine, angle, offset, count)
                case For():
                    self.loop(statement)

    def store(self, cell: Cell, value: Operand) -> None:
        slope = self.slope(value) or self.builder.lift(0)
        index = _substitute(cell.index, self.indices)
        if self.result(cell.array, index, slope):
            return
        if cell.array in self.arrays and cell.array in self.active:
            self.arrays[cell.array][index] = slope

    def result(self, array: str, index: Affine, slope: Expr) -> bool:
        """Write the derivative of a cell of an output; False where the array is none that is differentiated."""
        block = self.blocks.get(array)
        if block is None:
            return False
        target = ArrayRef(self.builder, block.name, 0)
        target[index * (block.columns or self.size) + block.column + self.seed] = slope
        return True

    def sincos(self, sine: str, cosine: str, angle: str, offset: int, count: int) -> None:
        with self.builder.loop("k", 0, count) as loop:
            k = loop.index
            turn = self.arrays[angle][k + offset]
            if sine in self.arrays:
                self.arrays[sine][k] = self.primal.arrays[cosine][k] * turn
            if cosine in self.arrays:
                self.arrays[cosine][k] = -(self.primal.arrays[sine][k] * turn)

    def loop(self, loop: For) -> None:
        start, stop = (_substitute(bound, self.indices) for bound in (loop.start, loop.stop))
        with self.builder.loop(loop.variable, start, stop, loop.step) as copied:
            self.indices[loop.variable] = copied.index
            self.inside.append(loop)
            carried = {}
            for carry in loop.carries:
                if carry.name in self.active:
                    initial = self.slope(carry.initial) or self.builder.lift(0)
                    carried[carry.name] = copied.carry(f"d_{carry.name}", initial)
            self.slopes.update(carried)
            self.walk(loop.body)
            for carry in loop.carries:
                if carry.name in carried:
                    copied.follow(carried[carry.name], self.slope(carry.following) or self.builder.lift(0))
            self.inside.pop()
            del self.indices[loop.variable]
        self.slopes.update(carried)

    def slope(self, operand: Operand) -> Expr | None:
        if isinstance(operand, Local):
            return self.slopes.get(operand.name)
        if isinstance(operand, Cell) and operand.array in self.arrays and operand.array in self.active:
            slope = self.arrays[operand.array][_substitute(operand.index, self.indices)]
            return None if slope.is_zero else slope
        return None

    def value(self, operand: Operand) -> Expr:
        if isinstance(operand, Const):
            return Expr(self.builder, operand)
        if isinstance(operand, Cell):
            return self.primal.arrays[operand.array][_substitute(operand.index, self.indices)]
        # inside its loop a carried value is that of the turn, after it the last one
        for found in (self.primal.kept.get(operand.name), self.primal.final.get(operand.name)):
            if found is not None and found.within(self.inside):
                return found.array[_substitute(found.position, self.indices)]
        value = self.primal.values[operand.name]
        if isinstance(value.operand, Cell):
            # the copy simplified the operation to a cell whose index names the copy's loop variables
            return Expr(self.builder, value.operand)
        return value


class _Direction(_Tangent):
    """Writes the derivative along a direction that arguments are given."""

    def __init__(
        self, builder: Builder, program: Program, primal: _Primal, moving: Sequence[str], results: Sequence[str]
    ) -> None:
        self.begin(builder, program, primal, moving)
        self.results = results
        for array in (*program.params, *program.inputs):
            if array.name in moving:
                self.arrays[array.name] = ArrayRef(builder, f"d_{array.name}", array.size)
        for array in program.outputs:  # which may be read again
            if array.name in results:
                self.arrays[array.name] = ArrayRef(builder, f"d_{array.name}", array.size)

    def result(self, array: str, index: Affine, slope: Expr) -> bool:
        """Write the derivative of a cell of an output."""
        if array not in self.results:
            return False
        ArrayRef(self.builder, f"d_{array}", 0)[index] = slope
        return True


def _active(program: Program, arguments: Sequence[str]) -> set[str]:
    """Names of values and arrays that depend on the arguments."""
    active = set(arguments)
    while True:
        before = len(active)
        _spread(program.body, active)
        if len(active) == before:
            return active


def _spread(statements: Sequence[Statement], active: set[str]) -> None:
    def moves(operand: Operand) -> bool:
        if isinstance(operand, Const):
            return False
        return (operand.name if isinstance(operand, Local) else operand.array) in active

    for statement in statements:
        match statement:
            case Op(result, _, args):
                if any(map(moves, args)):
                    active.add(result)
            case Store(cell, value):
                if moves(value):
                    active.add(cell.array)
            case SinCos(sine, cosine, angle):
                if angle in active:
                    active.update((sine, cosine))
            case For(carries=carries, body=body):
                for carry in carries:
                    if moves(carry.initial) or moves(carry.following):
                        active.add(carry.name)
                _spread(body, active)


def _substitute(index: Affine, indices: dict[str, Affine]) -> Affine:
    result = Affine(index.offset)
    for variable, coefficient in index.terms:
        result = result + indices.get(variable, Affine(0, ((variable, 1),))) * coefficient
    return result


def _label(name: str) -> str:
    return "" if name.startswith("_") else name


