"""Program -> Program: loops of one turn or none run out, arrays of one cell become values.

A writer states a sweep for any number of links; on short chains what is left of a loop may be a single turn. Operations keep
their order, and what the turn's index makes constant is folded.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from phichain.ir.builder import Builder, Expr
from phichain.ir.nodes import Affine, Call, Cell, For, Local, Op, Operand, Program, SinCos, Statement, Store
from phichain.ir.passes import prune


def without_short_loops(program: Program) -> Program:
    """The same function with every loop of at least two turns as it is, and none of fewer."""
    single = _single_cells(program)
    if not single and not any(_turns(loop) in (0, 1) for loop, _ in _loops(program.body, False)):
        return program
    return prune(_Rewriting(program, single).result())


def _turns(loop: For) -> int | None:
    """How often a loop runs; None where that differs from turn to turn of the loops around it."""
    count = (loop.stop - loop.start) * loop.step
    return None if count.terms else max(count.offset, 0)


def _loops(statements: Sequence[Statement], is_repeated: bool) -> Iterator[tuple[For, bool]]:
    """Every loop, and whether it stands inside one of several turns."""
    for statement in statements:
        if isinstance(statement, For):
            yield statement, is_repeated
            yield from _loops(statement.body, is_repeated or _turns(statement) not in (0, 1))


def _single_cells(program: Program) -> set[str]:
    """Work arrays of one cell that can be a value: written outside of all repetition, and handed over to no call."""
    single = {array.name for array in program.work if array.size == 1}
    blocks = [(program.body, False)]
    blocks += [(loop.body, outside or _turns(loop) not in (0, 1)) for loop, outside in _loops(program.body, False)]
    for block, is_repeated in blocks:
        for statement in block:
            match statement:
                case Store(Cell(array, _), _) if is_repeated:
                    single.discard(array)
                case Call(_, inputs, outputs):
                    single -= {*inputs, *outputs}
                case _:
                    pass
    for block, is_repeated in blocks:  # a run of sines writes memory, unless both its arrays are values
        for statement in block:
            if isinstance(statement, SinCos) and (is_repeated or not {statement.sine, statement.cosine} <= single):
                single -= {statement.sine, statement.cosine, statement.angle}
    return single


class _Recorder(Builder):
    """A Builder that takes statements on whole arrays as they are."""

    def record(self, statement: SinCos | Call) -> None:
        self._blocks[-1].statements.append(statement)


class _Rewriting:
    """Records one Program anew."""

    def __init__(self, program: Program, single: set[str]) -> None:
        self.program, self.single = program, single
        self.builder = _Recorder(program.name, program.doc)
        self.values: dict[str, Expr] = {}
        self.cells: dict[str, Expr] = {}
        self.indices: dict[str, Affine] = {}
        self.turns: dict[str, int] = {}

    def result(self) -> Program:
        builder, program = self.builder, self.program
        for declare, arrays in (
            (builder.param, program.params), (builder.input, program.inputs), (builder.output, program.outputs),
        ):  # fmt: skip
            for array in arrays:
                declare(array.name, array.shape, array.doc)
        for array in program.work:
            if array.name not in self.single:
                builder.array(array.name, array.size)
        for name, values in program.tables.items():
            builder.constants(name, values)
        builder.callees |= program.callees
        self.block(program.body)
        return builder.finish()

    # --- statements ---------------------------------------------------------------------------------------------------

    def block(self, statements: Sequence[Statement]) -> None:
        for statement in statements:
            match statement:
                case Op(result, kind, args):
                    self.values[result] = self.builder.apply(kind, *map(self.value, args), label=self.label(result))
                case Store(Cell(array, index), value):
                    if array in self.single:
                        self.cells[array] = self.value(value)
                    else:
                        self.builder.write(array, self.index(index), self.value(value))
                case SinCos():
                    self.sincos(statement)
                case For():
                    self.loop(statement)
                case Call():
                    self.builder.record(statement)

    def sincos(self, statement: SinCos) -> None:
        if statement.sine in self.single:
            angle = self.value(Cell(statement.angle, Affine(statement.offset)))
            self.cells[statement.sine], self.cells[statement.cosine] = self.builder.sin(angle), self.builder.cos(angle)
            return
        self.builder.record(statement)

    def loop(self, loop: For) -> None:
        loop = replace(loop, start=self.index(loop.start), stop=self.index(loop.stop))
        turns = _turns(loop)
        if turns in (0, 1):
            for carry in loop.carries:
                self.values[carry.name] = self.value(carry.initial)
            if turns:
                self.turn(loop)
            return
        with self.builder.loop(loop.variable, loop.start, loop.stop, loop.step) as record:
            self.indices[loop.variable] = record.index
            carried = {carry.name: record.carry(carry.name, self.value(carry.initial)) for carry in loop.carries}
            self.values |= carried
            self.block(loop.body)
            for carry in loop.carries:
                record.follow(carried[carry.name], self.value(carry.following))
        del self.indices[loop.variable]

    def turn(self, loop: For) -> None:
        """The only turn of a loop, in its place."""
        self.indices[loop.variable] = loop.start
        if not loop.start.terms:
            self.turns[loop.variable] = loop.start.offset
        self.block(loop.body)
        following = {carry.name: self.value(carry.following) for carry in loop.carries}
        self.values |= following
        del self.indices[loop.variable]
        self.turns.pop(loop.variable, None)

    # --- operands -----------------------------------------------------------------------------------------------------

    def label(self, name: str) -> str:
        """A quantity's name: in a turn that is run out `rate_k` and `rate` alike become `rate_3`, as in straight-line code."""
        if name.startswith("_"):
            return ""
        for variable, turn in self.turns.items():
            name = f"{name.removesuffix(f'_{variable}')}_{turn}"
        return name

    def value(self, operand: Operand) -> Expr:
        if isinstance(operand, Local):
            return self.values[operand.name]
        if isinstance(operand, Cell):
            if operand.array in self.single:
                return self.cells[operand.array]
            return self.builder.read(operand.array, self.index(operand.index))
        return Expr(self.builder, operand)

    def index(self, index: Affine) -> Affine:
        """An index in terms of the loops that are left."""
        total = Affine(index.offset)
        for variable, coefficient in index.terms:
            total = total + self.indices[variable] * coefficient
        return total
