"""Which values of a Program are angles: whatever reaches a sine or cosine through sums, differences and integer multiples.

In the field an angle is a pair, its value and its point (cosine, sine) of the unit circle. The two are independent, as an angle and
its sine are algebraically, and points add by the addition theorems. Everything else is a value alone.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from phichain.ir.nodes import (
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


class NotRational(Exception):
    """A Program takes a step that is no rational one, such as the sine of a product; says which."""


def angles_of(program: Program) -> frozenset[str]:
    """Names of the arrays and local values of a Program whose points of the circle are needed.

    Raises:
        NotRational: a sine or cosine is taken of what is no sum of angles.
    """
    found: set[str] = set()
    size = -1
    while len(found) != size:
        size = len(found)
        for statement in walk(program.body):
            found |= set(_names(_needed(statement, found)))
    return frozenset(found)


def _needed(statement: Statement, found: set[str]) -> Iterator[Operand | str]:
    """What a statement needs as angles, given what is known to be one."""
    match statement:
        case Op(_, "sin" | "cos", args):
            yield from args
        case SinCos(angle=angle):
            yield angle
        case Op(result, kind, args) if result in found:
            yield from _summands(kind, args)
        case Store(cell, value) if cell.array in found:
            yield value
        case For():
            for carry in statement.carries:
                if carry.name in found:
                    yield from (carry.initial, carry.following)
        case Call(callee, _, outputs) if found & set(outputs):
            raise NotRational(f"the sine of what {callee} returns")


def _summands(kind: str, args: tuple[Operand, ...]) -> Iterator[Operand]:
    if kind in ("add", "sub", "neg"):
        yield from args
        return
    whole = [arg for arg in args if isinstance(arg, Const) and arg.value.denominator == 1]
    if kind != "mul" or len(whole) != 1:
        raise NotRational(f"the sine of what is made by {kind}")
    yield from (arg for arg in args if arg is not whole[0])


def _names(needed: Iterable[Operand | str]) -> Iterator[str]:
    for entry in needed:
        match entry:
            case str(name) | Local(name) | Cell(name, _):
                yield name
            case Const(value) if value != 0:
                raise NotRational(f"the sine of the number {value}")
