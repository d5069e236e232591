"""Arrays of which a loop over rows of lanes hands one row on to the next turn and nobody reads another: one row is room enough.

A compiler keeps such a row in registers, while rows that stay behind are written to memory and read back, turn after turn.
"""

from __future__ import annotations

from dataclasses import dataclass

from phichain.ir.nodes import Affine, Call, Cell, For, Op, Program, SinCos, Statement, Store, walk


@dataclass(frozen=True)
class Row:
    """The row that stands for all rows of an array.

    Attributes:
        lanes: its cells.
        origin: index of the first lane of any row.
        lane: the variable of the loop over lanes.
    """

    lanes: int
    origin: int
    lane: str

    def cell(self, index: Affine) -> str:
        """Where a cell of the array stands in the row."""
        return self.lane if index.terms else str((index.offset - self.origin) % self.lanes)


def handed_on(program: Program) -> dict[str, Row]:
    """The work arrays of a Program that one row holds."""
    work = {array.name for array in program.work}
    found = dict[str, Row]()
    for place, rows in enumerate(program.body):
        if not isinstance(rows, For):
            continue
        for lanes in (s for s in rows.body if isinstance(s, For) and s.is_lanes):
            beside = tuple(statement for statement in rows.body if statement is not lanes)
            others = program.body[:place], beside, program.body[place + 1 :]
            found |= {
                name: Row(lanes.stop.offset, index.offset, lanes.variable)
                for name, index in _stored(lanes).items()
                if name in work and _is_handed_on(name, index, rows, lanes, others)
            }
    return found


def _stored(lanes: For) -> dict[str, Affine]:
    return {s.cell.array: s.cell.index for s in lanes.body if isinstance(s, Store)}


def _is_handed_on(
    name: str, index: Affine, rows: For, lanes: For, others: tuple[tuple[Statement, ...], ...]
) -> bool:
    """Whether the loop reads the row before alone, is given its first row ahead, and leaves its last one."""
    width, (before, beside, after) = lanes.stop.offset, others
    if index.terms != tuple(sorted(((rows.variable, width), (lanes.variable, 1)))) or rows.step < 0 or rows.start.terms or rows.stop.terms:
        return False
    first, last = (range(start := width * (bound.offset - 1) + index.offset, start + width) for bound in (rows.start, rows.stop))
    read, written = _cells(lanes.body, name)
    given, ahead = _cells(before, name)
    left, later = _cells(after, name)
    if any(map(any, _cells(beside, name))) or given or later or _whole((*before, *beside, *lanes.body, *after), name):
        return False
    inside = {cell.index for cell in read} <= {index + -width} and len(written) == 1
    return inside and _are_in(ahead, first) and _are_in(left, last)


def _are_in(cells: list[Cell], row: range) -> bool:
    return all(not cell.index.terms and cell.index.offset in row for cell in cells)


def cells_handed_on(loop: For, rows: dict[str, Row]) -> list[Cell]:
    """What a turn reads of such rows, which it writes anew at its end."""
    read = [cell for name in rows for cell in _cells(loop.body, name)[0]]
    return list(dict.fromkeys(read))


def _cells(statements: tuple[Statement, ...], name: str) -> tuple[list[Cell], list[Cell]]:
    """The cells of an array that statements read, and those that they write."""
    read, written = list[Cell](), list[Cell]()
    for statement in walk(statements):
        match statement:
            case Op(args=args):
                read += [arg for arg in args if isinstance(arg, Cell) and arg.array == name]
            case Store(cell, value):
                read += [value] if isinstance(value, Cell) and value.array == name else []
                written += [cell] if cell.array == name else []
            case For(carries=carries):
                ends = [end for carry in carries for end in (carry.initial, carry.following)]
                read += [end for end in ends if isinstance(end, Cell) and end.array == name]
            case _:
                pass
    return read, written


def _whole(statements: tuple[Statement, ...], name: str) -> bool:
    """Whether something takes the array as a whole."""
    for statement in walk(statements):
        match statement:
            case SinCos(sine, cosine, angle) if name in (sine, cosine, angle):
                return True
            case Call(_, inputs, outputs) if name in (*inputs, *outputs):
                return True
            case _:
                pass
    return False
