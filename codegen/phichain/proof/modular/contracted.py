"""A Jacobian's Program times a vector, for the price of one column: its loop over seeds runs once, along the vector.

Such a loop computes one column a turn, from a cell of a table that is one for its own seed and zero elsewhere. Where its body is linear
in that cell, which is read off its operations here, the sum over seeds of weight times column is one turn with the weights in the place
of the table. A loop that is anything else, a mutant's for example, is left as it is: every column is computed.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

from phichain.ir.nodes import (
    Affine,
    Array,
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
    walk,
)

ZERO = Const(Fraction(0))


class _Unlike(Exception):
    """The Program is no Jacobian that is made of such loops."""


@dataclass(frozen=True)
class Block:
    """What one loop over seeds contributes.

    Attributes:
        weights: the input that takes the weights; None where one seed's weight is applied afterwards.
        first: where in it the first seed's is.
        output: the result it belongs to.
        rows: the output that holds the loop's columns times the weights.
        column: the first column of the result that it computes.
        count: how many.
    """

    weights: Array | None
    first: int
    output: str
    rows: str
    column: int
    count: int


@dataclass(frozen=True)
class Contracted:
    """A Program whose outputs are sums over columns.

    Attributes:
        program: it takes weights in further inputs.
        blocks: which columns each of its outputs sums over.
    """

    program: Program
    blocks: tuple[Block, ...]


def contracted(program: Program) -> Contracted | None:
    """The Program times vectors, or None where it is not made of loops over seeds alone."""
    try:
        return _contracted(program)
    except _Unlike:
        return None


def _contracted(program: Program) -> Contracted:
    body: list[Statement] = []
    blocks: list[Block] = []
    outputs = {array.name: array for array in program.outputs}
    single: dict[tuple[str, int], str] = {}
    for statement in program.body:
        if isinstance(statement, For) and not statement.carries and _is_over_seeds(statement, outputs):
            _apart(program, statement)
            found = _Seeds(program, statement, outputs, len(blocks))
            body += found.body
            blocks.append(found.block)
        else:
            body.append(_in_rows(statement, outputs, single))
    blocks += [Block(None, 0, output, rows, column, 1) for (output, column), rows in single.items()]
    _cover(outputs, blocks)
    rows = tuple(Array(block.rows, (outputs[block.output].shape[0],)) for block in blocks)
    inputs = (*program.inputs, *(block.weights for block in blocks if block.weights))
    return Contracted(replace(program, inputs=inputs, outputs=rows, body=tuple(body)), tuple(blocks))


def _is_over_seeds(loop: For, outputs: dict[str, Array]) -> bool:
    """Whether a turn of a loop writes a column of its own."""
    cells = [s.cell for s in walk(loop.body) if isinstance(s, Store) and s.cell.array in outputs]
    return any(dict(cell.index.terms).get(loop.variable, 0) % outputs[cell.array].shape[-1] for cell in cells)


def _in_rows(statement: Statement, outputs: dict[str, Array], found: dict[tuple[str, int], str]) -> Statement:
    """What is written to an output outside of such loops, column by column; names of columns are kept in `found`."""
    match statement:
        case For():
            return replace(statement, body=tuple(_in_rows(inner, outputs, found) for inner in statement.body))
        case Store(Cell(array, index), value) if array in outputs:
            width = outputs[array].shape[-1]
            if any(factor % width for _, factor in index.terms):
                raise _Unlike
            rows = found.setdefault((array, index.offset % width), f"column_{len(found)}")
            return Store(Cell(rows, _divided(index, width)), value)
    return statement


def _divided(index: Affine, width: int) -> Affine:
    """The row of a cell, of an index whose variables step by whole rows."""
    return Affine(index.offset // width, tuple((variable, factor // width) for variable, factor in index.terms))


def _cover(outputs: dict[str, Array], blocks: Sequence[Block]) -> None:
    for name, array in outputs.items():  # every column belongs to one block
        columns = [block.column + i for block in blocks if block.output == name for i in range(block.count)]
        if sorted(columns) != list(range(array.shape[1] if len(array.shape) == 2 else -1)):
            raise _Unlike


def _writes(statements: Iterable[Statement]) -> set[str]:
    """The arrays that statements write to."""
    found: set[str] = set()
    for statement in walk(tuple(statements)):
        match statement:
            case Store(cell, _):
                found.add(cell.array)
            case SinCos(sine, cosine, _, _, _):
                found |= {sine, cosine}
            case Call(_, _, results):
                found |= set(results)
    return found


def _names(statements: Iterable[Statement]) -> Iterator[str]:
    """The local values that statements define."""
    for statement in walk(tuple(statements)):
        if isinstance(statement, Op):
            yield statement.result
        elif isinstance(statement, For):
            yield from (carry.name for carry in statement.carries)


def _apart(program: Program, loop: For) -> None:
    """What a turn writes, nobody else writes but outputs: then a turn that reads nothing unwritten reads nothing of another turn."""
    others = [statement for statement in program.body if statement is not loop]
    outputs = {array.name for array in program.outputs}
    if (_writes(loop.body) - outputs) & _writes(others) or set(_names(loop.body)) & set(_names(others)):
        raise _Unlike


class _Seeds:
    """One loop over seeds as one turn."""

    body: tuple[Statement, ...]
    block: Block

    def __init__(self, program: Program, loop: For, outputs: dict[str, Array], number: int) -> None:
        if loop.start != Affine(0) or loop.stop.terms or loop.step != 1:
            raise _Unlike
        self._seed, self._count = loop.variable, loop.stop.offset
        self._tables, self._outputs = program.tables, outputs
        self._weights = f"weights_{number}"
        self._rows = f"rows_{number}"
        self._shape: tuple[str, int, int] | None = None
        self._target: tuple[str, int] | None = None
        self._linear = self._depending(loop.body)
        self.body = tuple(self._statements(loop.body))
        if self._target is None or (self._shape is None and self._count > 1):
            raise _Unlike
        _, first, size = self._shape or ("", 0, 0)
        weights = Array(self._weights, (size,)) if self._shape else None
        output, column = self._target
        self.block: Block = Block(weights, first, output, self._rows, column, self._count)

    def _depending(self, body: tuple[Statement, ...]) -> set[str]:
        """The local values and arrays that depend on the seed."""
        found: set[str] = set()
        size = -1
        while len(found) != size:
            size = len(found)
            for statement in walk(body):
                match statement:
                    case Op(result, _, args) if any(self._depends(arg, found) for arg in args):
                        found.add(result)
                    case Store(cell, value) if self._depends(value, found):
                        found.add(cell.array)
                    case For():
                        found |= {
                            carry.name
                            for carry in statement.carries
                            if self._depends(carry.initial, found) or self._depends(carry.following, found)
                        }
        return found

    def _depends(self, operand: Operand, found: set[str]) -> bool:
        match operand:
            case Local(name):
                return name in found
            case Cell(name, index):
                return name in found or self._has_seed(index)
        return False

    def _has_seed(self, index: Affine) -> bool:
        return any(variable == self._seed for variable, _ in index.terms)

    def _is_linear(self, operand: Operand) -> bool:
        """Whether a value is a linear function of the seed's cell; zero is one."""
        return self._count == 1 or operand == ZERO or self._depends(operand, self._linear)

    def _statements(self, statements: Iterable[Statement]) -> Iterator[Statement]:
        for statement in statements:
            match statement:
                case Op():
                    yield self._operation(statement)
                case Store(cell, value):
                    yield self._store(cell, value)
                case For():
                    yield self._loop(statement)
                case _:
                    raise _Unlike

    def _operation(self, op: Op) -> Op:
        if op.result in self._linear and self._count > 1:
            depends = [self._depends(arg, self._linear) for arg in op.args]
            allowed = {
                "add": all(map(self._is_linear, op.args)),
                "sub": all(map(self._is_linear, op.args)),
                "neg": True,
                "mul": sum(depends) == 1,
                "div": depends[:2] == [True, False],
            }
            if not allowed.get(op.kind, False):
                raise _Unlike
        return replace(op, args=tuple(map(self._operand, op.args)))

    def _store(self, cell: Cell, value: Operand) -> Store:
        if cell.array in self._outputs:
            if not self._is_linear(value):
                raise _Unlike
            return Store(self._row(cell), self._operand(value))
        if self._has_seed(cell.index) or (cell.array in self._linear and not self._is_linear(value)):
            raise _Unlike
        return Store(cell, self._operand(value))

    def _loop(self, loop: For) -> For:
        if self._has_seed(loop.start) or self._has_seed(loop.stop) or loop.variable == self._seed:
            raise _Unlike
        for carry in loop.carries:
            if carry.name in self._linear and not (self._is_linear(carry.initial) and self._is_linear(carry.following)):
                raise _Unlike
        carries = tuple(
            replace(carry, initial=self._operand(carry.initial), following=self._operand(carry.following))
            for carry in loop.carries
        )
        return replace(loop, carries=carries, body=tuple(self._statements(loop.body)))

    def _operand(self, operand: Operand) -> Operand:
        """A cell of the table becomes the weight of the seed whose cell is one there."""
        if not isinstance(operand, Cell) or not self._has_seed(operand.index):
            return operand
        if self._count == 1:
            return replace(operand, index=self._without_seed(operand.index))
        values = self._tables.get(operand.array, ())
        ones = [i for i, value in enumerate(values) if value != 0]
        if len(ones) != 1 or values[ones[0]] != 1 or dict(operand.index.terms)[self._seed] != -1:
            raise _Unlike
        # table[e - seed] is one for seed = e - one; e - seed within the table for all seeds bounds that from both sides.
        one, least = ones[0], self._count - 1 - ones[0]
        shape = (operand.array, -least, len(values) - self._count + 1)
        if self._shape not in (None, shape) or not 0 <= -least < shape[2]:
            raise _Unlike
        self._shape = shape
        return Cell(self._weights, self._without_seed(operand.index) - (one + least))

    def _row(self, cell: Cell) -> Cell:
        """Row and first column of what a turn writes."""
        width = self._outputs[cell.array].shape[-1]
        index = self._without_seed(cell.index)
        column = index.offset % width
        target = (cell.array, column)
        whole = dict(cell.index.terms).get(self._seed) == 1 and not any(factor % width for _, factor in index.terms)
        if not whole or column + self._count > width or self._target not in (None, target):
            raise _Unlike
        self._target = target
        return Cell(self._rows, _divided(index, width))

    def _without_seed(self, index: Affine) -> Affine:
        return Affine(index.offset, tuple(term for term in index.terms if term[0] != self._seed))
