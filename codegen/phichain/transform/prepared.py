"""Program -> two Programs: what the runtime parameters alone determine, and the rest.

A function of runtime parameters begins with tables of them: where it is called many times with the same ones, the first
Program runs once and the second as often as wanted.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

from phichain.ir.nodes import (
    Affine,
    Array,
    Carry,
    Cell,
    For,
    Local,
    Op,
    Operand,
    Program,
    SinCos,
    Statement,
    Store,
)
from phichain.ir.passes import prune

#: What the first Program computes and the second is given.
PREPARED = "prepared"


@dataclass(frozen=True)
class Split:
    """A Program in two parts.

    Attributes:
        first: runtime parameters -> `prepared`.
        rest: the function, with `prepared` as its last input.
        size: number of cells of `prepared`.
    """

    first: Program
    rest: Program
    size: int


def prepared(program: Program) -> Split | None:
    """Split a Program without calls; None where its parameters alone determine nothing worth keeping.

    Statements stand or move as a whole: in a loop that reads an input everything stays.
    """
    moving = _moving(program)
    still = tuple(s for s in program.body if not _defined(s) & moving)
    rest = tuple(s for s in program.body if _defined(s) & moving)
    wanted = {name for s in rest for name in _read(s)} & {name for s in still for name in _defined(s)}
    sizes = {array.name: array.size for array in program.work if array.name in wanted}
    base, size = {}, 0
    for name in sorted(wanted):
        base[name] = size
        size += sizes.get(name, 1)
    if not size:
        return None
    keep = tuple(_kept(name, sizes.get(name), offset) for name, offset in base.items())
    out = Array(PREPARED, (size,), "what the runtime parameters alone determine")
    first = replace(
        program, name="prepare", doc="What the runtime parameters alone determine.", inputs=(), outputs=(out,),
        body=(*still, *keep),
    )  # fmt: skip
    given = _Given(base)
    second = replace(program, inputs=(*program.inputs, out), body=tuple(map(given.statement, rest)))
    return Split(prune(first), prune(second), size)


def _moving(program: Program) -> frozenset[str]:
    """Names of all that depends on inputs, or stands in a statement with something that does."""
    found = {array.name for array in (*program.inputs, *program.outputs)}
    while True:
        before = len(found)
        for statement in program.body:
            if (_read(statement) | _defined(statement)) & found:
                found |= _defined(statement)
        if len(found) == before:
            return frozenset(found)


def _defined(statement: Statement) -> set[str]:
    match statement:
        case Op(result):
            return {result}
        case Store(cell):
            return {cell.array}
        case SinCos(sine, cosine):
            return {sine, cosine}
        case For(carries=carries, body=body):
            return {carry.name for carry in carries}.union(*map(_defined, body))
    raise AssertionError("calls are put in place before a Program is split")


def _read(statement: Statement) -> set[str]:
    match statement:
        case Op(args=args):
            return set(_names(args))
        case Store(value=value):
            return set(_names((value,)))
        case SinCos(angle=angle):
            return {angle}
        case For(carries=carries, body=body):
            ends = [end for carry in carries for end in (carry.initial, carry.following)]
            return set(_names(ends)).union(*map(_read, body))
    raise AssertionError("calls are put in place before a Program is split")


def _names(operands: Iterable[Operand]) -> Iterator[str]:
    for operand in operands:
        if isinstance(operand, Local):
            yield operand.name
        elif isinstance(operand, Cell):
            yield operand.array


def _kept(name: str, size: int | None, offset: int) -> Statement:
    """A value, or an array of that size, written into its place in `prepared`."""
    if size is None:
        return Store(Cell(PREPARED, Affine(offset)), Local(name))
    turn = Affine(0, (("k", 1),))
    copy = Store(Cell(PREPARED, turn + offset), Cell(name, turn))
    return For("k", Affine(0), Affine(size), 1, (), (copy,), (0, size - 1))


class _Given:
    """Statements with what was prepared read from its place."""

    def __init__(self, base: dict[str, int]) -> None:
        self.base = base

    def operand(self, operand: Operand) -> Operand:
        match operand:
            case Local(name) if name in self.base:
                return Cell(PREPARED, Affine(self.base[name]))
            case Cell(array, index) if array in self.base:
                return Cell(PREPARED, index + self.base[array])
        return operand

    def statement(self, statement: Statement) -> Statement:
        match statement:
            case Op():
                return replace(statement, args=tuple(map(self.operand, statement.args)))
            case Store():
                return replace(statement, value=self.operand(statement.value))
            case For():
                carries = tuple(
                    Carry(carry.name, self.operand(carry.initial), self.operand(carry.following))
                    for carry in statement.carries
                )
                return replace(statement, carries=carries, body=tuple(map(self.statement, statement.body)))
        return statement
