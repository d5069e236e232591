"""Which values of a Program depend on given inputs."""

from __future__ import annotations

from collections.abc import Iterable

from phichain.ir.nodes import Call, Cell, For, Local, Op, Operand, Program, SinCos, Statement, Store


def varying(program: Program, moving: Iterable[str]) -> frozenset[str]:
    """Names of all results, carried scalars and arrays that depend on the inputs `moving`.

    Args:
        program: straight-line code or loops, without calls.
        moving: names of inputs.
    """
    found = set(moving)
    while True:
        before = len(found)
        _spread(program.body, found)
        if len(found) == before:
            return frozenset(found)


def _spread(statements: tuple[Statement, ...], found: set[str]) -> None:
    for statement in statements:
        match statement:
            case Op(result, _, args):
                _mark(result, args, found)
            case Store(cell, value):
                _mark(cell.array, (value,), found)
            case SinCos(sine, cosine, angle):
                found.update((sine, cosine) if angle in found else ())
            case For():
                for carry in statement.carries:
                    _mark(carry.name, (carry.initial, carry.following), found)
                _spread(statement.body, found)
            case Call():
                raise AssertionError("calls are put in place before dependences are followed")


def _mark(name: str, operands: Iterable[Operand], found: set[str]) -> None:
    if any(_name(operand) in found for operand in operands):
        found.add(name)


def _name(operand: Operand) -> str:
    match operand:
        case Local(name):
            return name
        case Cell(array, _):
            return array
    return ""
