"""Program -> Program: neighbouring loops over the same links are one loop, and what it hands on within a turn has no cell.

A loop costs a target some twenty bytes and a handful of instructions a turn; an array that only carries a value from one loop to
the next costs memory. Two loops become one where no turn of either needs another turn of the other, and what stands between
them may as well stand before both or after both.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

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
from phichain.ir.reads import read_in


@dataclass(frozen=True)
class _Uses:
    """What a statement reads and writes: arrays with the indices used, None where it takes all of one; values by name."""

    read: frozenset[tuple[str, Affine | None]]
    written: frozenset[tuple[str, Affine | None]]
    wanted: frozenset[str]
    made: frozenset[str]

    @property
    def arrays_read(self) -> set[str]:
        """The arrays, whatever the index."""
        return {array for array, _ in self.read}

    @property
    def arrays_written(self) -> set[str]:
        """Likewise."""
        return {array for array, _ in self.written}


def with_fused_loops(program: Program) -> Program:
    """The same function with neighbouring loops in one, and values in place of cells that a turn writes and reads again."""
    done: list[Statement] = []
    for statement in program.body:
        if not (isinstance(statement, For) and _joined(done, statement)):
            done.append(statement)
    own = {array.name for array in program.work}
    return replace(program, body=tuple(_handed_on(one, own) if isinstance(one, For) else one for one in done))


def _joined(done: list[Statement], loop: For) -> bool:
    """Put a loop's turns into those of one before, if that may be."""
    own = _uses(loop)
    for place in range(len(done) - 1, -1, -1):
        before, between = done[place], [_uses(statement) for statement in done[place + 1 :]]
        if isinstance(before, For) and _go_together(before, loop):
            whole = replace(before, carries=before.carries + loop.carries, body=before.body + loop.body)
            if all(_may_swap(statement, own) for statement in between):
                done[place] = whole
                return True
            first = _uses(before)
            if all(_may_swap(first, statement) for statement in between):
                del done[place]
                done.append(whole)
                return True
    return False


def _go_together(first: For, second: For) -> bool:
    """Whether two loops take the same turns, none of which needs another one's results."""
    if (first.variable, first.start, first.stop, first.step) != (second.variable, second.start, second.stop, second.step):
        return False
    a, b = _uses(first), _uses(second)
    if a.made & b.wanted:
        return False
    shared = (a.arrays_written & (b.arrays_read | b.arrays_written)) | (a.arrays_read & b.arrays_written)
    indices: dict[str, set[Affine | None]] = {}
    for array, index in a.read | a.written | b.read | b.written:
        indices.setdefault(array, set()).add(index)
    turn = ((first.variable, 1),)
    return all(len(indices[array]) == 1 and all(index is not None and index.terms == turn for index in indices[array]) for array in shared)


def _may_swap(first: _Uses, second: _Uses) -> bool:
    """Whether two statements may come in the other order."""
    return not (
        first.arrays_written & (second.arrays_read | second.arrays_written)
        or first.arrays_read & second.arrays_written
        or first.made & second.wanted
    )


def _uses(statement: Statement) -> _Uses:
    read, written, made = set[tuple[str, Affine | None]](), set[tuple[str, Affine | None]](), set[str]()
    wanted = set[str]()
    for one in _inside(statement):
        match one:
            case Op(result, _, _):
                made.add(result)
            case Store(cell, _):
                written.add((cell.array, cell.index))
            case SinCos(sine, cosine, angle):
                written |= {(sine, None), (cosine, None)}
                read.add((angle, None))
            case Call(_, inputs, outputs):
                read |= {(name, None) for name in inputs}
                written |= {(name, None) for name in outputs}
            case For(carries=carries):
                made |= {carry.name for carry in carries}
        for operand in _operands(one):
            if isinstance(operand, Cell):
                read.add((operand.array, operand.index))
            elif isinstance(operand, Local):
                wanted.add(operand.name)
    return _Uses(frozenset(read), frozenset(written), frozenset(wanted - made), frozenset(made))


def _inside(statement: Statement) -> Iterator[Statement]:
    yield statement
    if isinstance(statement, For):
        for inner in statement.body:
            yield from _inside(inner)


def _operands(statement: Statement) -> Iterator[Operand]:
    match statement:
        case Op(args=args):
            yield from args
        case Store(value=value):
            yield value
        case For(carries=carries):
            for carry in carries:
                yield from (carry.initial, carry.following)


def _handed_on(loop: For, own: set[str]) -> For:
    """A loop whose turns read what they have just written as a value; nothing else changes."""
    known: dict[Cell, Operand] = {}

    def value(operand: Operand) -> Operand:
        return known.get(operand, operand) if isinstance(operand, Cell) else operand

    body: list[Statement] = []
    for statement in loop.body:
        written = _uses(statement).arrays_written
        left = {cell: operand for cell, operand in known.items() if cell.array not in written}
        # Turns of a loop within may read what earlier ones of them have written.
        known = left if isinstance(statement, For) else known
        here = read_in(statement, value)
        body.append(here)
        known = left
        if isinstance(here, Store) and here.cell.array in own and isinstance(here.value, Local | Const):
            known[here.cell] = here.value
    carries = tuple(replace(carry, following=value(carry.following)) for carry in loop.carries)
    return replace(loop, carries=carries, body=tuple(body))
