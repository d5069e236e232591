"""Jacobians of Programs with loops: the original once, then its derivative along one direction a turn of one more loop.

The derivative of a statement stands where the statement stood. What it needs of the original's loop bodies is kept in work
arrays, one cell a turn; what does not depend on the argument is left out (activity).
"""

from __future__ import annotations

from collections.abc import Sequence

from phichain.ir.builder import ArrayRef, Builder, Expr
from phichain.ir.nodes import Affine, Cell, Const, For, Local, Op, Operand, Program, SinCos, Statement, Store
from phichain.transform.blocks import Block
from phichain.transform.derivatives import directional
from phichain.transform.primal import Primal, substitute


def loop_jacobian(builder: Builder, program: Program, blocks: Sequence[Block], keep_outputs: bool) -> Program:
    """Fill `builder`, whose arguments are declared, with the Jacobians of `program`."""
    primal = Primal(builder, program, keep_outputs)
    primal.copy(program.body)
    sizes = {array.name: array.size for array in (*program.params, *program.inputs)}
    for argument in dict.fromkeys(block.argument for block in blocks):
        mine = [block for block in blocks if block.argument == argument]
        with builder.loop("seed", 0, sizes[argument]) as seeds:
            _Tangent(builder, program, primal, argument, sizes[argument], seeds.index, mine).walk(program.body)
    return builder.finish()


def loop_direction(builder: Builder, program: Program, moving: Sequence[str], results: Sequence[str]) -> Program:
    """Fill `builder`, whose arguments are declared, with the derivatives of `results` along how arguments move."""
    primal = Primal(builder, program, False)
    primal.copy(program.body)
    _Direction(builder, program, primal, moving, results).walk(program.body)
    return builder.finish()


class _Tangent:
    """Writes the derivative along one unit direction of one argument."""

    def __init__(
        self, builder: Builder, program: Program, primal: Primal, argument: str, size: int, seed: Affine,
        blocks: Sequence[Block],
    ) -> None:  # fmt: skip
        self.seed = seed
        self.blocks, self.size = {block.output: block for block in blocks}, size
        self.begin(builder, program, primal, (argument,))
        # one_hot[size - 1 + i - seed] is 1 at i = seed and 0 elsewhere
        one_hot = builder.table(f"one_hot_{size}", 2 * size - 1, lambda i: int(i == size - 1))
        self.arrays[argument] = one_hot.shifted(size - 1 - seed)

    def begin(self, builder: Builder, program: Program, primal: Primal, arguments: Sequence[str]) -> None:
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
        index = substitute(cell.index, self.indices)
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
        start, stop = (substitute(bound, self.indices) for bound in (loop.start, loop.stop))
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
            slope = self.arrays[operand.array][substitute(operand.index, self.indices)]
            return None if slope.is_zero else slope
        return None

    def value(self, operand: Operand) -> Expr:
        if isinstance(operand, Const):
            return Expr(self.builder, operand)
        if isinstance(operand, Cell):
            return self.primal.arrays[operand.array][substitute(operand.index, self.indices)]
        # inside its loop a carried value is that of the turn, after it the last one
        for found in (self.primal.kept.get(operand.name), self.primal.final.get(operand.name)):
            if found is not None and found.within(self.inside):
                return found.array[substitute(found.position, self.indices)]
        value = self.primal.values[operand.name]
        if isinstance(value.operand, Cell):
            # the copy simplified the operation to a cell whose index names the copy's loop variables
            return Expr(self.builder, value.operand)
        return value


class _Direction(_Tangent):
    """Writes the derivative along a direction that arguments are given."""

    def __init__(
        self, builder: Builder, program: Program, primal: Primal, moving: Sequence[str], results: Sequence[str]
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
