"""Loops or straight-line code for the Programs of a recurrence, as a scene asks or by operation count."""

from __future__ import annotations

from dataclasses import replace

from phichain.ir.nodes import Affine, Cell, For, Local, Op, Operand, Program, Statement, Store
from phichain.ir.passes import prune, total_operations, unroll
from phichain.ir.short_loops import without_short_loops
from phichain.lowering.lower import UNROLL_LIMIT
from phichain.lowering.series.series import COEFFICIENT, NEXT, NOW


def shaped(loops: Program, code: str) -> Program:
    """The same function as `code` says: "unrolled", "loops" or, for "auto", whichever its operations speak for."""
    whole = prune(loops)
    if code == "loops" or (code == "auto" and total_operations(whole) > 2 * UNROLL_LIMIT):
        return without_short_loops(whole)
    flat = unroll(whole)
    is_flat = code == "unrolled" or total_operations(flat) <= UNROLL_LIMIT
    return flat if is_flat else without_short_loops(whole)


def with_rates_in_a_loop(program: Program, size: int) -> Program:
    """The same order with what follows from rates, q_{n+1} = q'_n / (n + 1), as a loop where the rest is straight-line code.

    These are copies but for a factor: one by one they are a quarter of what an order stores, and nothing waits for them.

    Args:
        program: an order.
        size: entries of q.
    """
    if not program.is_straight_line:
        return program
    share = Cell(NOW, Affine(1))
    made = {statement.result: statement for statement in program.body if isinstance(statement, Op)}
    rates = [_rate(statement, made, share, size) for statement in program.body]
    if sorted(at for at in rates if at is not None) != list(range(size)):
        return program
    turn = Affine(0, (("i", 1),))
    rate = Cell(COEFFICIENT, turn + size)
    body = (Op("rate_i", "mul", (share, rate)), Store(Cell(NEXT, turn), Local("rate_i")))
    loop = For("i", Affine(0), Affine(size), 1, (), body, (0, size - 1))
    kept = tuple(statement for statement, at in zip(program.body, rates, strict=True) if at is None)
    return prune(replace(program, body=(*kept, loop)))


def _rate(statement: Statement, made: dict[str, Op], share: Operand, size: int) -> int | None:
    """Which entry of q_{n+1} a statement stores, if it is the share of its own rate; else None."""
    if not (isinstance(statement, Store) and statement.cell.array == NEXT and isinstance(statement.value, Local)):
        return None
    value, at = made.get(statement.value.name), statement.cell.index.at({})
    if value is None or value.kind != "mul" or share not in value.args:
        return None
    other = value.args[value.args[0] == share]
    return at if other == Cell(COEFFICIENT, Affine(at + size)) else None
