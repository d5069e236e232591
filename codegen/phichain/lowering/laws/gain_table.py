"""A table of gains as Programs that are given a row of it: the level, how far the links are, and the law.

Which entries of a row are ever other than zero is known; only these are kept, and only these cost something.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from phichain.ir.builder import ArrayRef, Builder, Expr
from phichain.ir.nodes import Program
from phichain.ir.passes import prune
from phichain.ir.piecewise import wrapped
from phichain.laws import GainTable
from phichain.lowering.laws.state_feedback import full_turn, limited

Places = tuple[tuple[int, int], ...]


@dataclass(frozen=True)
class TablePrograms:
    """The Programs of a table, and what a row of it holds.

    Attributes:
        level: `level(x_meas, target, shape) -> level`.
        apart: `apart(x_meas, target) -> apart`, the squared distance of the links.
        law: `law(x_meas, target, gains[, rest]) -> u`.
        shape: (row, column) of the entries of W that are kept, in their order.
        gains: (row, column) of those of K.
        has_rest: Whether an equilibrium needs an input at rest.
    """

    level: Program
    apart: Program
    law: Program
    shape: Places
    gains: Places
    has_rest: bool

    def row(self, table: GainTable, which: int) -> dict[str, tuple[float, ...]]:
        """One equilibrium's row of the table by field."""
        found = {
            "target": table.targets[which],
            "gains": tuple(table.gains[which][i][j] for i, j in self.gains),
            "shape": tuple(table.shapes[which][i][j] for i, j in self.shape),
        }
        return found | ({"rest": table.rest[which]} if self.has_rest else {})


def table_programs(table: GainTable) -> TablePrograms:
    """The Programs of a table."""
    shape, gains = _places(table.shapes), _places(table.gains)
    has_rest = any(value for row in table.rest for value in row)
    return TablePrograms(_level(table, shape), _apart(table), _law(table, gains, has_rest), shape, gains, has_rest)


def _places(matrices: tuple[tuple[tuple[float, ...], ...], ...]) -> Places:
    rows, columns = len(matrices[0]), len(matrices[0][0])
    return tuple((i, j) for i in range(rows) for j in range(columns) if any(one[i][j] for one in matrices))


def _level(table: GainTable, shape: Places) -> Program:
    builder = Builder("level", "How far the state is from an equilibrium: at most 1 where its law is to take over.")
    measured, target = _given(builder, table)
    cells = builder.input("shape", (len(shape),), "its ellipsoid")
    out = builder.output("level", (), "|W w(x_meas - target)|^2")
    away = _away(builder, table, measured, target, {j for _, j in shape})
    total = builder.lift(0)
    for row in sorted({i for i, _ in shape}):
        part = builder.lift(0)
        for k, (i, j) in enumerate(shape):
            if i == row:
                part = part + cells[k] * away[j]
        part = builder.let(f"part_{row + 1}", part)
        total = total + part * part
    out[0] = total
    return prune(builder.finish())


def _apart(table: GainTable) -> Program:
    builder = Builder("apart", "How far the links are from those of an equilibrium, squared.")
    measured, target = _given(builder, table)
    out = builder.output("apart", (), "sum of squares")
    away = _away(builder, table, measured, target, set(table.compared))
    total = builder.lift(0)
    for j in table.compared:
        total = total + away[j] * away[j]
    out[0] = total
    return prune(builder.finish())


def _law(table: GainTable, gains: Places, has_rest: bool) -> Program:
    builder = Builder("law", "Inputs that lead to an equilibrium.")
    measured, target = _given(builder, table)
    cells = builder.input("gains", (len(gains),), "its gains")
    rest = builder.input("rest", (len(table.input_names),), "inputs at rest") if has_rest else None
    inputs = builder.output("u", (len(table.input_names),), "inputs")
    away = _away(builder, table, measured, target, {j for _, j in gains})
    for row, (low, high) in enumerate(zip(table.low, table.high, strict=True)):
        u: Expr = rest[row] if rest else builder.lift(0)
        for k, (i, j) in enumerate(gains):
            if i == row:
                u = u - cells[k] * away[j]
        inputs[row] = limited(builder.let(f"{table.input_names[row]}_wanted", u), low, high)
    return prune(builder.finish())


def _given(builder: Builder, table: GainTable) -> tuple[ArrayRef, ArrayRef]:
    nx = len(table.state_names)
    return builder.input("x_meas", (nx,), "measured state, (q, v)"), builder.input("target", (nx,), "the equilibrium")


def _away(builder: Builder, table: GainTable, measured: ArrayRef, target: ArrayRef, wanted: set[int]) -> dict[int, Expr]:
    turn: Fraction = full_turn()
    found = {}
    for i in sorted(wanted):
        away = measured[i] - target[i]
        found[i] = builder.let(f"{table.state_names[i]}_away", wrapped(away, turn) if table.wraps[i] else away)
    return found
