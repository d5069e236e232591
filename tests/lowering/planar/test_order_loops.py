"""Orders of planar flows in loops: what is stored number by number is not read as vectors by what follows within the order."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from phichain.ir.builder import Builder
from phichain.ir.nodes import Cell, For, Op, Operand, Program, Statement, Store, walk
from phichain.lowering.series import series
from phichain.lowering.series.series import COEFFICIENT, NEXT, NOW
from phichain.lowering.series.shape import with_rates_in_a_loop
from phichain.mechanics import derive
from phichain.scene import Scene

ALIKE: dict[str, Any] = {"mass": [0.125] * 8, "length": [0.125] * 8, "com": [0.0625] * 8}
CHAINS = {
    "plain": Scene("plain", 8, **ALIKE),
    "cart": Scene("cart", 8, **ALIKE, base="cart", cart_mass=0.5),
    "tips": Scene("tips", 8, mass=[0.125] * 8, length=[0.125] * 8),
    "springs": Scene("springs", 8, **ALIKE, stiffness=[2.0] * 8, damping=[0.1] * 8),
}
#: Rates of links, from which those of joints are made: nothing of the order waits for these.
LATE = {"turn"}


def operands(statement: Statement) -> tuple[Operand, ...]:
    """What a statement reads."""
    match statement:
        case Op(args=args):
            return args
        case Store(value=value):
            return (value,)
        case For(carries=carries):
            return tuple(operand for carry in carries for operand in (carry.initial, carry.following))
        case _:
            return ()


def read(statements: tuple[Statement, ...]) -> set[str]:
    """The arrays that statements read."""
    return {operand.array for statement in walk(statements) for operand in operands(statement) if isinstance(operand, Cell)}


def waited_for(program: Program) -> set[str]:
    """Arrays that a loop with carried numbers stores and that a later loop without reads."""
    stored, found = set[str](), set[str]()
    for statement in program.body:
        if not isinstance(statement, For):
            continue
        if statement.carries:
            stored |= {inner.cell.array for inner in walk(statement.body) if isinstance(inner, Store)}
        else:
            found |= stored & read(statement.body)
    return found


@pytest.mark.parametrize("name", CHAINS)
def test_no_loop_waits_for_what_is_stored_one_by_one(name: str) -> None:
    order = series(derive(CHAINS[name])).order
    assert waited_for(order) <= LATE
    assert sum(bool(statement.carries) for statement in order.body if isinstance(statement, For)) == 2


def test_what_waits_is_seen() -> None:
    """A loop that stores what it carries, and one beside the chain that reads it."""
    order = series(derive(CHAINS["plain"])).order
    carrying = next(statement for statement in order.body if isinstance(statement, For) and statement.carries)
    stored = next(inner.cell for inner in walk(carrying.body) if isinstance(inner, Store))
    beside = For("k", carrying.start, carrying.stop, carrying.step, (), (Op("again", "neg", (stored,)),), carrying.hull)
    assert waited_for(replace(order, body=(carrying, beside))) == {stored.array}


def test_shares_of_rates_are_a_loop_in_space() -> None:
    order = series(derive(Scene("shares", 5, space="spatial", mass=[0.1] * 5, length=[0.1] * 5, base="cart", cart_mass=0.5))).order
    loops = [statement for statement in order.body if isinstance(statement, For)]
    assert [(loop.start.offset, loop.stop.offset, len(loop.body)) for loop in loops] == [(0, 17, 2)]


@pytest.mark.parametrize(("first", "second"), [(2, 3), (3, 2), (3, 3)])
def test_shares_of_other_rates_stay_as_they_are(first: int, second: int) -> None:
    """Entry i is the share of its own rate, which stands as many cells behind it as there are angles."""
    b = Builder("flow_order", "")
    now, row, out = b.input(NOW, (4,)), b.input(COEFFICIENT, (4,)), b.output(NEXT, (4,))
    for i, entry in enumerate((now[1] * row[first], now[1] * row[second], row[0], row[1])):
        out[i] = entry
    program = b.finish()
    assert (with_rates_in_a_loop(program, 2) == program) == ((first, second) != (2, 3))
