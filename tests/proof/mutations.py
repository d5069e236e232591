"""Mutants of Programs, made systematically: one small change of one statement each, of every kind that a fault could be."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import pairwise

from phichain.ir.nodes import Carry, Cell, Const, For, Op, Operand, Program, Statement, Store

Change = Callable[[Statement], Iterator[Statement]]
"""The changed forms of one statement."""


@dataclass(frozen=True)
class Mutant:
    """A Program with one change.

    Attributes:
        kind: what was changed.
        program: the changed Program.
    """

    kind: str
    program: Program


def mutants(program: Program, per_kind: int) -> Iterator[Mutant]:
    """Up to so many mutants of each kind, spread evenly over the Program."""
    outputs = {array.name for array in program.outputs}
    for kind, change in CHANGES.items():
        bodies = list(_changed(program.body, change))
        yield from (Mutant(kind, replace(program, body=body)) for body in _spread(bodies, per_kind))
    swaps = list(_swapped(program.body, outputs))
    yield from (Mutant("outputs swapped", replace(program, body=body)) for body in _spread(swaps, per_kind))
    entries = [(name, i) for name, values in program.tables.items() for i in range(len(values))]
    for name, i in _spread(entries, per_kind):
        values = [_one_ulp(value) if k == i else value for k, value in enumerate(program.tables[name])]
        yield Mutant("table entry", replace(program, tables=program.tables | {name: tuple(values)}))


def _spread(found: Sequence, count: int) -> list:
    if len(found) <= count:
        return list(found)
    return [found[(2 * i + 1) * len(found) // (2 * count)] for i in range(count)]


def _changed(body: tuple[Statement, ...], change: Change) -> Iterator[tuple[Statement, ...]]:
    """Every body that differs from this one by one change of one statement, however deep it stands."""
    for i, statement in enumerate(body):
        before, after = body[:i], body[i + 1 :]
        for other in change(statement):
            yield (*before, other, *after)
        if isinstance(statement, For):
            for inner in _changed(statement.body, change):
                yield (*before, replace(statement, body=inner), *after)


def _kinds(exchange: dict[str, str]) -> Change:
    def change(statement: Statement) -> Iterator[Statement]:
        if isinstance(statement, Op) and statement.kind in exchange:
            yield replace(statement, kind=exchange[statement.kind])

    return change


def _operands_swapped(statement: Statement) -> Iterator[Statement]:
    if isinstance(statement, Op) and statement.kind in ("sub", "div"):
        yield replace(statement, args=statement.args[::-1])


def _operands(change: Callable[[Operand], Operand | None]) -> Change:
    """Changes of one operand."""

    def changes(statement: Statement) -> Iterator[Statement]:
        match statement:
            case Op(_, _, args):
                for i, arg in enumerate(args):
                    if (other := change(arg)) is not None:
                        yield replace(statement, args=(*args[:i], other, *args[i + 1 :]))
            case Store(_, value):
                if (other := change(value)) is not None:
                    yield replace(statement, value=other)
            case For():
                for i, carry in enumerate(statement.carries):
                    for moved in _carried(carry, change):
                        yield replace(statement, carries=(*statement.carries[:i], moved, *statement.carries[i + 1 :]))

    return changes


def _carried(carry: Carry, change: Callable[[Operand], Operand | None]) -> Iterator[Carry]:
    if (other := change(carry.initial)) is not None:
        yield replace(carry, initial=other)
    if (other := change(carry.following)) is not None:
        yield replace(carry, following=other)


def _one_ulp(value: Fraction) -> Fraction:
    near = float(value)
    return Fraction(math.nextafter(near, math.inf)) if near else Fraction(math.ulp(1.0))


def _constant(operand: Operand) -> Operand | None:
    return Const(_one_ulp(operand.value)) if isinstance(operand, Const) else None


def _shifted(by: int) -> Callable[[Operand], Operand | None]:
    def change(operand: Operand) -> Operand | None:
        return Cell(operand.array, operand.index + by) if isinstance(operand, Cell) else None

    return change


def _stored_elsewhere(statement: Statement) -> Iterator[Statement]:
    if isinstance(statement, Store):
        yield replace(statement, cell=Cell(statement.cell.array, statement.cell.index + 1))


def _negated(statement: Statement) -> Iterator[Statement]:
    """-x for x: a factor or a stored value with the other sign."""
    if isinstance(statement, Op) and statement.kind == "mul" and isinstance(statement.args[0], Const):
        yield replace(statement, args=(Const(-statement.args[0].value), statement.args[1]))
    if isinstance(statement, Op) and statement.kind == "neg":
        yield replace(statement, kind="add", args=(statement.args[0], Const(Fraction(0))))


def _short(statement: Statement) -> Iterator[Statement]:
    if isinstance(statement, For):
        yield replace(statement, stop=statement.stop - statement.step)
        yield replace(statement, start=statement.start + statement.step)


def _swapped(body: tuple[Statement, ...], outputs: set[str]) -> Iterator[tuple[Statement, ...]]:
    """Bodies in which two stores to an output have exchanged their cells."""
    stores = [i for i, s in enumerate(body) if isinstance(s, Store) and s.cell.array in outputs]
    for i, k in pairwise(stores):
        one, other = body[i], body[k]
        if isinstance(one, Store) and isinstance(other, Store) and one.value != other.value:
            changed = list(body)
            changed[i], changed[k] = replace(one, cell=other.cell), replace(other, cell=one.cell)
            yield tuple(changed)


CHANGES: dict[str, Change] = {
    "add and sub": _kinds({"add": "sub", "sub": "add"}),
    "mul and div": _kinds({"mul": "div", "div": "mul"}),
    "sin and cos": _kinds({"sin": "cos", "cos": "sin"}),
    "Bessel orders": _kinds({f"besselj{n}": f"besselj{n + 1}" for n in range(4)}),
    "operands swapped": _operands_swapped,
    "sign": _negated,
    "constant by one ulp": _operands(_constant),
    "index one up": _operands(_shifted(1)),
    "index one down": _operands(_shifted(-1)),
    "stored one up": _stored_elsewhere,
    "loop one short": _short,
}
