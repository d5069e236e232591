"""Program -> Program: work arrays that are given the same values at the same places are one array, and copies are what they copy.

Forms are written for any chain; on one whose links are alike several of their quantities may coincide.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from phichain.ir.nodes import Affine, Call, Cell, For, Op, Operand, Program, SinCos, Statement, Store, walk
from phichain.ir.passes import prune
from phichain.ir.reads import reading

#: Where a store stands: the loops around it by their places, and its own.
Place = tuple[int, ...]


def without_twins(program: Program) -> Program:
    """The same function with one array in place of several that hold the same: the one that is written first."""
    stores: dict[str, list[tuple[Place, Affine, Operand]]] = {}
    for place, store in _stores(program.body, ()):
        stores.setdefault(store.cell.array, []).append((place, store.cell.index, store.value))
    whole = {name for statement in walk(program.body) for name in _whole(statement)}
    own = {array.name for array in program.work}
    alike: dict[tuple[object, ...], str] = {}
    twins: dict[str, str] = {}
    for array in sorted((array for array in program.work if array.name in stores), key=lambda array: stores[array.name][0][0]):
        written = stores[array.name]
        what = (array.shape, *((place[:-1], index, value) for place, index, value in written))
        first = alike.setdefault(what, array.name)
        is_later = all(one[0] < other[0] for one, other in zip(stores[first], written, strict=True))
        if first != array.name and is_later and not whole & {first, array.name}:
            twins[array.name] = first
    copied = {name: source for name in stores if name in own - whole and (source := _copied(stores[name])) is not None}
    # Sines stand in pairs of their own; beside a link's other quantities a copy takes one pointer less, which counts three loops deep.
    beside = {name for name in copied if copied[name] in whole} & set(_read_within(program.body, 0))
    twins |= {name: source for name, source in copied.items() if source in own - {*twins, *copied} and name not in {*twins.values(), *beside}}
    if not twins:
        return program
    same = reading(program, lambda operand: Cell(twins[operand.array], operand.index) if isinstance(operand, Cell) and operand.array in twins else operand)
    return prune(replace(same, body=tuple(_without(same.body, set(twins)))))


def _stores(statements: tuple[Statement, ...], around: Place) -> Iterator[tuple[Place, Store]]:
    for number, statement in enumerate(statements):
        if isinstance(statement, Store):
            yield (*around, number), statement
        elif isinstance(statement, For):
            yield from _stores(statement.body, (*around, number))


def _copied(stores: list[tuple[Place, Affine, Operand]]) -> str | None:
    """The array whose cells an array repeats, each in its place."""
    sources = {value.array if isinstance(value, Cell) and value.index == index else None for _, index, value in stores}
    return sources.pop() if len(sources) == 1 else None


def _read_within(statements: tuple[Statement, ...], depth: int) -> Iterator[str]:
    """Arrays that are read three loops deep."""
    for statement in statements:
        if isinstance(statement, For):
            yield from _read_within(statement.body, depth + 1)
        elif isinstance(statement, Op) and depth > 2:
            yield from (operand.array for operand in statement.args if isinstance(operand, Cell))


def _whole(statement: Statement) -> tuple[str, ...]:
    """Arrays that a statement takes as they are."""
    match statement:
        case SinCos(sine, cosine, angle):
            return sine, cosine, angle
        case Call(_, inputs, outputs):
            return (*inputs, *outputs)
        case _:
            return ()


def _without(statements: tuple[Statement, ...], arrays: set[str]) -> Iterator[Statement]:
    for statement in statements:
        if isinstance(statement, For):
            yield replace(statement, body=tuple(_without(statement.body, arrays)))
        elif not (isinstance(statement, Store) and statement.cell.array in arrays):
            yield statement
