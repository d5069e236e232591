"""The factors of the products of a Taylor recurrence, each kept once.

`jets` gives every product rows of its own for its two factors, which is what loops over links want. In straight-line code
most factors belong to several products (a sine turns two components, one inverse divides nine terms): kept once, they take
less than half the memory, and products that share one find it in the nearest cache.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

from phichain.ir.nodes import Affine, Array, Carry, Cell, For, Op, Operand, Program, Statement, Store
from phichain.transform.lanes import FIRST, LEFT, RIGHT, Jets

#: The one array of factors, in the place of LEFT and RIGHT.
FACTORS: Final = "jet_factor"


@dataclass(frozen=True)
class Factored:
    """Taylor recurrences whose products refer to factors.

    Attributes:
        start, follow: as in `Jets`, with FACTORS and FACTORS + FIRST in the place of the lanes' rows.
        count: number of factors.
        left, right: factor of each product; None where product k has factors k and `products` + k.
        products: number of products.
    """

    start: Program
    follow: Program
    count: int
    left: tuple[int, ...] | None
    right: tuple[int, ...] | None
    products: int


def factored(recurrences: Jets, stride: int) -> Factored:
    """Put the factors of all products into one array.

    Args:
        recurrences: what `jets` made.
        stride: cells from a factor to the next, so that the orders of a factor may lie side by side.
    """
    start, follow, products = recurrences.start, recurrences.follow, recurrences.products
    if not (start.is_straight_line and follow.is_straight_line):
        places = {LEFT: 0, RIGHT: products}
        size = (2 * products - 1) * stride + 1
        one, all_others = (_moved(p, lambda cell: _run(cell, places, stride), size) for p in (start, follow))
        return Factored(one, all_others, 2 * products, None, None, products)
    numbers: dict[tuple[Operand, Operand], int] = {}
    of_cell: dict[tuple[str, int], int] = {}
    first, later = _stored(start), _stored(follow)
    for place in sorted(first):
        of_cell[place] = numbers.setdefault((first[place], later[place]), len(numbers))
    size = (len(numbers) - 1) * stride + 1
    one, all_others = (_moved(p, lambda cell: _single(cell, of_cell, stride), size) for p in (start, follow))
    left, right = (tuple(of_cell[name, k] for k in range(products)) for name in (LEFT, RIGHT))
    return Factored(one, all_others, len(numbers), left, right, products)


def _stored(program: Program) -> dict[tuple[str, int], Operand]:
    """What straight-line code writes to each cell of the lanes."""
    stores = (s for s in program.body if isinstance(s, Store) and s.cell.array in (LEFT, RIGHT))
    return {(s.cell.array, s.cell.index.offset): s.value for s in stores}


def _run(cell: Cell, places: dict[str, int], stride: int) -> Cell:
    name = cell.array.removesuffix(FIRST)
    suffix = cell.array.removeprefix(name)
    return Cell(FACTORS + suffix, (cell.index + places[name]) * stride)


def _single(cell: Cell, of_cell: dict[tuple[str, int], int], stride: int) -> Cell:
    name = cell.array.removesuffix(FIRST)
    number = of_cell[name, cell.index.offset]
    return Cell(FACTORS + cell.array.removeprefix(name), Affine(number * stride))


def _moved(program: Program, place: object, size: int) -> Program:
    """The Program with its lanes' cells moved, each written once."""
    lanes = {LEFT, RIGHT, LEFT + FIRST, RIGHT + FIRST}

    def operand(given: Operand) -> Operand:
        return place(given) if isinstance(given, Cell) and given.array in lanes else given  # type: ignore[operator]

    written: set[Operand] = set()

    def statements(body: tuple[Statement, ...]) -> tuple[Statement, ...]:
        found: list[Statement] = []
        for statement in body:
            match statement:
                case Op(result, kind, args):
                    found.append(Op(result, kind, tuple(map(operand, args))))
                case Store(cell, value):
                    moved = operand(cell)
                    if cell.array not in lanes or moved not in written:
                        found.append(Store(moved, operand(value)))  # type: ignore[arg-type]
                        written.add(moved)
                case For(carries=carries, body=inner):
                    moves = tuple(Carry(c.name, operand(c.initial), operand(c.following)) for c in carries)
                    found.append(replace(statement, carries=moves, body=statements(inner)))
                case _:
                    found.append(statement)
        return tuple(found)

    def arrays(given: tuple[Array, ...]) -> tuple[Array, ...]:
        kept = [array for array in given if array.name not in lanes]
        suffixes = {
            array.name.removeprefix(LEFT).removeprefix(RIGHT) for array in given if array.name in lanes
        }
        return (*kept, *(Array(FACTORS + suffix, (size,)) for suffix in sorted(suffixes)))

    return replace(
        program, body=statements(program.body), inputs=arrays(program.inputs), outputs=arrays(program.outputs)
    )
