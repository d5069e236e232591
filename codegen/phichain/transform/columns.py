"""Program -> Program: the same function for several columns of arguments side by side.

Cell i of a wide array becomes the cells ``width i + column``, and every run of operations a loop over the columns, so that
a compiler vectorises across columns whatever the data flow is. What has to live from one run to the next, carried scalars
among it, is kept in arrays. Arrays that are the same for all columns stay as they are.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace

from phichain.errors import EmissionError
from phichain.ir.nodes import Affine, Array, Cell, For, Local, Op, Operand, Program, Statement, Store

#: Name of the new loops' variable.
COLUMN = "column"
#: Operations in one run: compilers take time that grows faster than the length of a loop.
LONGEST_RUN = 120


def columns(program: Program, width: int, shared: Iterable[str]) -> Program:
    """The function applied to `width` columns at once.

    Args:
        program: straight-line code or loops; neither calls nor runs of sines.
        width: number of columns.
        shared: arrays that hold the same for all columns.

    Raises:
        EmissionError: a statement has no such form.
    """
    return _Widening(program, width, frozenset(shared)).result()


class _Widening:
    """Rewrites one Program."""

    def __init__(self, program: Program, width: int, shared: frozenset[str]) -> None:
        self.program, self.width = program, width
        arrays = (*program.inputs, *program.outputs, *program.work)
        self.wide = {array.name for array in arrays if array.name not in shared}
        self.crossing = _crossing(program.body)
        self.kept: dict[str, Affine] = {}
        self.work: list[Array] = []

    def result(self) -> Program:
        body = tuple(self.block(program_runs(self.program.body)))
        program = self.program
        return replace(
            program, body=body, inputs=tuple(map(self.widened, program.inputs)),
            outputs=tuple(map(self.widened, program.outputs)),
            work=(*map(self.widened, program.work), *self.work),
        )  # fmt: skip

    def widened(self, array: Array) -> Array:
        return replace(array, shape=(array.size * self.width,)) if array.name in self.wide else array

    # --- statements -------------------------------------------------------------------------------------------------------

    def block(self, pieces: Iterable[list[Statement] | For]) -> Iterator[Statement]:
        for piece in pieces:
            if isinstance(piece, For):
                yield from self.loop(piece)
            else:
                yield self.run(list(self.statements(piece)))

    def run(self, body: Sequence[Statement]) -> For:
        return For(COLUMN, Affine(0), Affine(self.width), 1, (), tuple(body), (0, self.width - 1))

    def statements(self, run: list[Statement]) -> Iterator[Statement]:
        for statement in run:
            match statement:
                case Op(result, kind, args):
                    yield Op(result, kind, tuple(map(self.operand, args)))
                    if result in self.crossing:
                        yield self.keep(result, Local(result))
                case Store(cell, value):
                    yield Store(self.cell(cell), self.operand(value))
                case _:
                    raise EmissionError(
                        "columns",
                        type(statement).__name__,
                        "has no form for several columns",
                        "write it as operations",
                    )
        for statement in run:
            if isinstance(statement, Op) and statement.result in self.crossing:
                self.kept[statement.result] = Affine(0)

    def keep(self, name: str, value: Operand) -> Store:
        """Put a value aside for later runs of the same turn."""
        self.work.append(Array(_kept(name), (self.width,)))
        return Store(self.place(_kept(name), Affine(0)), value)

    def loop(self, loop: For) -> Iterator[Statement]:
        """The loop; carried scalars live in arrays, one row a turn, since a cell is written once."""
        low, high = loop.hull
        turn = (Affine(0, ((loop.variable, 1),)) - loop.start) * loop.step
        first, last = [], []
        for carry in loop.carries:
            self.work.append(Array(_kept(carry.name), ((max(high - low + 1, 0) + 1) * self.width,)))
            first.append(Store(self.place(_kept(carry.name), Affine(0)), self.operand(carry.initial)))
            self.kept[carry.name] = turn
        body = list(self.block(program_runs(loop.body)))
        for carry in loop.carries:
            last.append(Store(self.place(_kept(carry.name), turn + 1), self.operand(carry.following)))
        if first:
            yield self.run(first)
        yield replace(loop, carries=(), body=(*body, self.run(last)) if last else tuple(body))
        for carry in loop.carries:
            self.kept[carry.name] = (loop.stop - loop.start) * loop.step

    # --- operands ---------------------------------------------------------------------------------------------------------

    def operand(self, operand: Operand) -> Operand:
        if isinstance(operand, Cell):
            return self.cell(operand)
        if isinstance(operand, Local) and operand.name in self.kept:
            return self.place(_kept(operand.name), self.kept[operand.name])
        return operand

    def cell(self, cell: Cell) -> Cell:
        return self.place(cell.array, cell.index) if cell.array in self.wide else cell

    def place(self, array: str, index: Affine) -> Cell:
        return Cell(array, index * self.width + Affine(0, ((COLUMN, 1),)))


def program_runs(statements: Iterable[Statement]) -> Iterator[list[Statement] | For]:
    """The statements as runs without loops, of bounded length, and the loops between them."""
    run: list[Statement] = []
    for statement in statements:
        if isinstance(statement, For) or len(run) >= LONGEST_RUN:
            if run:
                yield run
            run = []
        if isinstance(statement, For):
            yield statement
        else:
            run.append(statement)
    if run:
        yield run


def _kept(name: str) -> str:
    """The array of a value that lives longer than a run."""
    return f"value{name}_columns" if name.startswith("_") else f"{name}_columns"


def _crossing(statements: Iterable[Statement]) -> frozenset[str]:
    """Results of operations that another run, or what a loop hands on, uses."""
    found: set[str] = set()
    for piece in program_runs(statements):
        if isinstance(piece, For):
            found |= _crossing(piece.body) | {
                name for carry in piece.carries for name in _names((carry.initial,))
            }
            found |= {name for carry in piece.carries for name in _names((carry.following,))}
        else:
            defined = {statement.result for statement in piece if isinstance(statement, Op)}
            found |= {name for statement in piece for name in _names(_uses(statement)) if name not in defined}
    return frozenset(found)


def _uses(statement: Statement) -> tuple[Operand, ...]:
    match statement:
        case Op(args=args):
            return args
        case Store(value=value):
            return (value,)
    return ()


def _names(operands: Iterable[Operand]) -> set[str]:
    return {operand.name for operand in operands if isinstance(operand, Local)}
