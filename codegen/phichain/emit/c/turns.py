"""What a turn of a loop keeps at hand where room is dear: pointers to the records it uses, and cells it reads more than once.

Compilers that optimise nothing find every cell anew at each use, by a multiplication and three additions; what is kept in registers
costs one instruction. Those that optimise make the same of both.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterator
from dataclasses import dataclass

from phichain.ir.nodes import Affine, Call, Cell, For, Op, Operand, SinCos, Statement, Store, walk


@dataclass(frozen=True)
class Row:
    """Cells of one array, or of records, that a turn finds by one pointer.

    Attributes:
        array: the array; "" for the records.
        start: where the pointer points.
        is_written: whether something is written through it.
    """

    array: str
    start: Affine
    is_written: bool


Key = tuple[str, tuple[tuple[str, int], ...]]


def key(cell: Cell, fields: Collection[str]) -> Key:
    """What cells have in common that one pointer finds: their array and what of their index varies; of records, the whole index."""
    if cell.array in fields:
        return "", (*cell.index.terms, ("", cell.index.offset))
    return cell.array, cell.index.terms


def rows(loop: For, fields: Collection[str], apart: Collection[str], known: Collection[Key]) -> dict[Key, Row]:
    """What a turn uses more than once, the loops in it included, by what finds it: records, and rows of arrays.

    A turn itself uses the first cell of each, so that no pointer leaves its array.

    Args:
        loop: the loop.
        fields: arrays that are fields of records.
        apart: arrays to leave alone, numbers among them.
        known: what a turn of a loop around it has found.
    """
    written = [statement.cell for statement in walk(loop.body) if isinstance(statement, Store)]
    directly = [*_read_directly(loop), *(statement.cell for statement in loop.body if isinstance(statement, Store))]
    uses = Counter(key(cell, fields) for cell in (*_read(loop), *written) if cell.array not in apart)
    stored = {key(cell, fields) for cell in written}
    found = dict[Key, Row]()
    for cell in directly:
        name = key(cell, fields)
        if uses[name] < 2 or name in known or not cell.index.terms:
            continue
        first = found[name].start.offset if name in found else cell.index.offset
        found[name] = Row(name[0], Affine(min(first, cell.index.offset), cell.index.terms), name in stored)
    return {name: row for name, row in found.items() if not row.array or _is_strided(row.start)}


def _is_strided(index: Affine) -> bool:
    """Whether finding a cell anew takes a product or a sum of variables."""
    return len(index.terms) > 1 or abs(index.terms[0][1]) != 1


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
