"""Which values of a Program are angles: whatever reaches a sine or cosine through sums, differences and integer multiples.

In the field an angle is a pair, its value and its point (cosine, sine) of the unit circle. The two are independent, as an angle and
its sine are algebraically, and points add by the addition theorems. A summand that is made otherwise, such as h times a rate, has a
point of its own, one for each value (`Point.atom`). Everything else is a value alone.
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


def angles_of(program: Program) -> frozenset[str]:
    """Names of the arrays and local values of a Program whose points of the circle are needed."""
    found: set[str] = set()
    # From the sines backwards to what they are taken of; loops carry it round.
    statements, size = list(walk(program.body))[::-1], -1
    while len(found) != size:
        size = len(found)
        for statement in statements:
            found |= set(_names(_needed(statement, found)))
            if isinstance(statement, Call):
                callee = program.callees[statement.callee]
                inner = angles_of(callee)
                pairs = zip(callee.inputs, statement.inputs, strict=True)
                found |= {name for array, name in pairs if array.name in inner}
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


def _summands(kind: str, args: tuple[Operand, ...]) -> Iterator[Operand]:
    if kind in ("add", "sub", "neg"):
        yield from args
    elif (multiple := whole_multiple(kind, args)) is not None:
        yield multiple[1]


def whole_multiple(kind: str, args: tuple[Operand, ...]) -> tuple[int, Operand] | None:
    """(n, x) of an operation n x with an integer n; None of any other."""
    if kind != "mul":
        return None
    for factor, other in (args, args[::-1]):
        if isinstance(factor, Const) and factor.value.denominator == 1 and not isinstance(other, Const):
            return int(factor.value), other
    return None


def _names(needed: Iterable[Operand | str]) -> Iterator[str]:
    for entry in needed:
        match entry:
            case str(name) | Local(name) | Cell(name, _):
                yield name
