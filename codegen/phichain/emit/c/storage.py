"""Where the work arrays of a function stand: in the cells of others that have served, and side by side, a record a link.

A record is found by one pointer, and its fields lie within an instruction's reach; dozens of arrays want a pointer each.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType

from phichain.emit.inlining import used_once
from phichain.ir.nodes import Call, Cell, For, Local, Op, Operand, Program, SinCos, Statement, Store, walk

#: Arrays this much shorter than most others are fields beside them (one longer would make a record more), and so many make it worth while.
_OF_ONE_LENGTH, _FEWEST_FIELDS = 2, 4


@dataclass(frozen=True)
class Storage:
    """Where the work arrays of a Program stand.

    Attributes:
        sizes: cells of each array that has a place of its own.
        guests: arrays that stand in the cells of another one, and that one's name.
        fields: the field of each array that records hold, arrays that share cells the same: `free_then_pass_yx`.
        extent: how many records.
    """

    sizes: Mapping[str, int]
    guests: Mapping[str, str]
    fields: Mapping[str, str] = field(default_factory=lambda: MappingProxyType({}))
    extent: int = 0

    @property
    def cells(self) -> int:
        """All cells together."""
        apart = sum(size for name, size in self.sizes.items() if name not in self.fields)
        return apart + self.extent * len(set(self.fields.values()))


def own_storage(program: Program) -> Storage:
    """Every array in a place of its own."""
    return Storage(MappingProxyType({array.name: array.size for array in program.work}), MappingProxyType({}))


def shared_storage(program: Program, has_pairs: bool = False) -> Storage:
    """Arrays one after another in the same cells, by the outermost statements that use them, and those of one length in records.

    Sines and cosines that a kernel sets in pairs take in nobody: one guest would set them apart.
    An array takes the place of one whose last use lies before its own first: the place that needs to grow least, and of
    those the smallest. Arrays of one cell are variables and stay by themselves.
    """
    spans = _spans(program)
    sizes, guests, free_from = dict[str, int](), dict[str, str](), dict[str, int]()
    alone = {name for one in walk(program.body) if isinstance(one, SinCos) for name in (one.sine, one.cosine)} if has_pairs else set[str]()
    for array in sorted(program.work, key=lambda array: spans[array.name]):
        first, last = spans[array.name]
        free = [name for name, end in free_from.items() if end < first] if array.size > 1 else []
        if free:
            place = min(free, key=lambda name: (max(array.size - sizes[name], 0), sizes[name], name))
            guests[array.name] = place
            sizes[place], free_from[place] = max(sizes[place], array.size), last
        else:
            sizes[array.name] = array.size
            if array.size > 1 and array.name not in alone:
                free_from[array.name] = last
    return _in_records(program, Storage(MappingProxyType(sizes), MappingProxyType(guests)))


def _in_records(program: Program, storage: Storage) -> Storage:
    """The same with the arrays that are used cell by cell, and are as long as most of them or hardly shorter, in records."""
    whole = {name for statement in walk(program.body) if isinstance(statement, SinCos | Call) for name in _names(statement)}
    tenants = {place: [place, *(name for name, other in storage.guests.items() if other == place)] for place in storage.sizes}
    sizes = {place: size for place, size in storage.sizes.items() if size > 1 and not whole & set(tenants[place])}
    counts = Counter(sizes.values())
    usual = min(counts, key=lambda size: (-counts[size], size), default=0)
    places = [place for place, size in sizes.items() if 0 <= usual - size <= _OF_ONE_LENGTH]
    if len(places) < _FEWEST_FIELDS:
        return storage
    fields = {name: "_then_".join(tenants[place]) for place in places for name in tenants[place]}
    return replace(storage, fields=MappingProxyType(fields), extent=max(sizes[place] for place in places))


def _spans(program: Program) -> dict[str, tuple[int, int]]:
    """The first and the last outermost statement that uses each work array.

    What is written where it is used is read there, and not where the Program says.
    """
    spans: dict[str, tuple[int, int]] = {array.name: (len(program.body), -1) for array in program.work}
    later, in_place = dict[str, frozenset[str]](), used_once(program.body)
    for place, statement in enumerate(program.body):
        named = set(_names(statement))
        used = named | frozenset().union(*(later.pop(name) for name in named & set(later)))
        if isinstance(statement, Op) and statement.result in in_place:
            later[statement.result] = frozenset(used)
        for name in used & set(spans):
            spans[name] = min(spans[name][0], place), place
    return spans


def _names(statement: Statement) -> Iterator[str]:
    """Arrays and values that a statement uses."""
    match statement:
        case Op(args=args):
            yield from map(_name, args)
        case Store(cell, value):
            yield from (cell.array, _name(value))
        case SinCos(sine, cosine, angle):
            yield from (sine, cosine, angle)
        case Call(_, inputs, outputs):
            yield from (*inputs, *outputs)
        case For(carries=carries, body=body):
            for carry in carries:
                yield from (_name(carry.initial), _name(carry.following))
            for inner in body:
                yield from _names(inner)


def _name(operand: Operand) -> str:
    match operand:
        case Cell(array, _):
            return array
        case Local(name):
            return name
        case _:
            return ""
