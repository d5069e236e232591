"""What a turn of a loop keeps at hand where room is dear: pointers to the records it uses, and cells it reads more than once.

Compilers that optimise nothing find every cell anew at each use, by a multiplication and three additions; what is kept in registers
costs one instruction. Those that optimise make the same of both.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterator

from phichain.ir.nodes import Affine, Call, Cell, For, Op, Operand, SinCos, Statement, Store, walk


def record_indices(loop: For, fields: Collection[str], known: Collection[Affine], open_loops: Collection[str]) -> dict[Affine, bool]:
    """Which records are used more than once within a turn, the loops in it included, and whether one of their cells is written.

    Args:
        loop: the loop.
        fields: arrays that are fields of records.
        known: indices that a turn of a loop around it has found.
        open_loops: variables of the loops around it.
    """
    within = {*open_loops, loop.variable}
    read = [cell for cell in _read(loop) if cell.array in fields]
    written = [s.cell for s in walk(loop.body) if isinstance(s, Store) and s.cell.array in fields]
    uses = Counter(cell.index for cell in (*read, *written))
    stored = {cell.index for cell in written}
    return {
        index: index in stored for index, count in uses.items()
        if count > 1 and index not in known and index.terms and {name for name, _ in index.terms} <= within
    }  # fmt: skip


def cells_read_again(loop: For, apart: Collection[str]) -> list[Cell]:
    """Cells that a turn itself reads more than once while nothing writes their arrays.

    Args:
        loop: the loop.
        apart: arrays to leave alone, numbers among them.
    """
    changed = {*apart}
    for statement in walk(loop.body):
        match statement:
            case Store(cell, _):
                changed.add(cell.array)
            case SinCos(sine, cosine, _):
                changed |= {sine, cosine}
            case Call(_, _, outputs):
                changed |= {*outputs}
            case _:
                pass
    uses = Counter(cell for cell in _read_directly(loop) if cell.array not in changed)
    return [cell for cell, count in uses.items() if count > 1]


def _read(loop: For) -> Iterator[Cell]:
    """Every cell that a turn reads."""
    yield from _read_directly(loop)
    for statement in loop.body:
        if isinstance(statement, For):
            yield from _read(statement)


def _read_directly(loop: For) -> Iterator[Cell]:
    """The cells that a turn reads outside of the loops in it."""
    for statement in loop.body:
        yield from (operand for operand in _operands(statement) if isinstance(operand, Cell))
    yield from (carry.following for carry in loop.carries if isinstance(carry.following, Cell))


def _operands(statement: Statement) -> tuple[Operand, ...]:
    match statement:
        case Op(args=args):
            return args
        case Store(value=value):
            return (value,)
        case For(carries=carries):
            return tuple(carry.initial for carry in carries)
        case _:
            return ()
