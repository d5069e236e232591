"""A table with observers and integrals as Programs that are given a row of it, one for each part of a call.

    apart(y)            squared distance of what is measured of the links
    start(y)         -> z at rest, as it is first measured
    estimate(z, y)   -> z, corrected by the measurement; z = w(y - y_0) where there is no observer
    level(z)            |W z|^2
    begin(z)         -> I
    law(z, I)        -> u
    expect(z, u)     -> z that is expected at the next call
    grow(z, I, y)    -> I at the next call

A number that is the same for all equilibria is part of the Programs; only the others are in the rows, and only these cost something.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

from phichain.ir.builder import ArrayRef, Builder, Expr
from phichain.ir.nodes import Cell, Op, Program, Store
from phichain.ir.passes import prune
from phichain.ir.piecewise import wrapped
from phichain.laws import OutputTable
from phichain.lowering.laws.output_feedback import finite, grown
from phichain.lowering.laws.state_feedback import full_turn, limited

Matrix = tuple[tuple[float, ...], ...]

_ABOUT = {
    "z": "deviation from the equilibrium", "y_meas": "measurement", "integral": "integrals of deviations over time", "u": "inputs",
    "expected": "deviation that is expected",
}  # fmt: skip


@dataclass(frozen=True)
class Field:
    """One matrix of a row.

    Attributes:
        name: What it is called there.
        values: The matrix of each equilibrium.
        kept: (row, column) of the entries that are not the same for all.
    """

    name: str
    values: tuple[Matrix, ...]
    kept: tuple[tuple[int, int], ...]

    @staticmethod
    def of(name: str, values: Sequence[Matrix]) -> Field:
        """A field that keeps what differs."""
        first = values[0]
        places = [(i, j) for i in range(len(first)) for j in range(len(first[i]))]
        return Field(name, tuple(values), tuple((i, j) for i, j in places if any(one[i][j] != first[i][j] for one in values)))

    def row(self, which: int) -> tuple[float, ...]:
        """What one equilibrium's row holds."""
        return tuple(self.values[which][i][j] for i, j in self.kept)


@dataclass(frozen=True)
class OutputTablePrograms:
    """The Programs of a table by name, in the order in which they are printed, and what a row of it holds.

    Attributes:
        parts: The Programs.
        fields: Fields of a row that hold anything.
    """

    parts: dict[str, Program]
    fields: tuple[Field, ...]

    def row(self, which: int) -> dict[str, tuple[float, ...]]:
        """One equilibrium's row of the table by field."""
        return {field.name: field.row(which) for field in self.fields}


class _Part:
    """One Program under construction, with what it reads of a row."""

    def __init__(self, table: OutputTable, fields: dict[str, Field], name: str, doc: str, given: Sequence[tuple[str, int]], read: Sequence[str]) -> None:
        self.table, self.law, self.builder = table, table.laws[0], Builder(name, doc)
        self.given = {what: self.builder.input(what, (size,), _ABOUT[what]) for what, size in given}
        self.fields = {name: fields[name] for name in read}
        self.cells: dict[str, ArrayRef] = {
            name: self.builder.input(name, (len(field.kept),), "of the equilibrium") for name, field in self.fields.items() if field.kept
        }

    def entry(self, field: str, i: int, j: int) -> Expr:
        """One number of a row, or what all rows have there."""
        one = self.fields[field]
        return self.cells[field][one.kept.index((i, j))] if (i, j) in one.kept else self.builder.lift(one.values[0][i][j])

    def product(self, field: str, i: int, values: Sequence[Expr]) -> Expr:
        """One row of a matrix times a vector."""
        total = self.builder.lift(0)
        for j, value in enumerate(values):
            total = total + self.entry(field, i, j) * value
        return total

    def off(self, only: Sequence[int] | None = None, wraps: bool = True) -> dict[int, Expr]:
        """y - y_0, less whole turns where it is said."""
        found = {}
        for i in range(len(self.law.measured_names)) if only is None else only:
            away = self.given["y_meas"][i] - self.entry("offsets", 0, i)
            away = wrapped(away, full_turn()) if wraps and self.law.wraps[i] else away
            found[i] = self.builder.let(f"{self.law.measured_names[i]}_away", away)
        return found

    def wanted(self) -> list[Expr]:
        """The inputs without their limits."""
        z, found = [self.given["z"][i] for i in range(len(self.law.deviation_names))], []
        for row, name in enumerate(self.law.input_names):
            u = self.entry("rest", 0, row) - self.product("gains", row, z)
            if self.law.integrated:
                u = u - self.product("integral_gains", row, [self.given["integral"][k] for k in range(len(self.law.integrated))])
            found.append(self.builder.let(f"{name}_wanted", u))
        return found

    def finish(self, name: str, values: Sequence[Expr], scalar: bool = False) -> Program:
        """The Program, its results stored, given nothing of a row that it does not read."""
        out = self.builder.output(name, () if scalar else (len(values),), "result")
        for i, value in enumerate(values):
            out[i] = value
        program = prune(self.builder.finish())
        return replace(program, inputs=tuple(array for array in program.inputs if array.name in {*self.given, *_read(program)}))


def _read(program: Program) -> set[str]:
    """The arrays that a straight-line Program reads."""
    found: set[str] = set()
    for statement in program.body:
        operands = statement.args if isinstance(statement, Op) else (statement.value,) if isinstance(statement, Store) else ()
        found |= {operand.array for operand in operands if isinstance(operand, Cell)}
    return found


def output_table_programs(table: OutputTable) -> OutputTablePrograms:
    """The Programs of a table."""
    law, fields = table.laws[0], _fields(table)
    n, nu, ny, ni = len(law.deviation_names), len(law.input_names), len(law.measured_names), len(law.integrated)
    part = partial(_Part, table, fields)
    seen, pushed = ("seen", "correction") if law.observer else (), ("rest", "gains", *(("integral_gains",) if ni else ()))
    z, y, integral = ("z", n), ("y_meas", ny), ("integral", ni)
    parts = [_apart(part("apart", "How far what is measured of the links is from an equilibrium, squared.", [y], ["offsets"]))]
    if law.observer:
        parts.append(_start(part("start", "The deviation at rest that is first measured.", [y], ["offsets", "start"])))
    before = [("expected", n), y] if law.observer else [y]
    parts.append(_estimate(part("estimate", "The deviation as it is measured.", before, ["offsets", *seen])))
    parts.append(_level(part("level", "How far the deviation is out: at most 1 where the law is to take over.", [z], ["shape"])))
    if ni:
        parts.append(_begin(part("begin", "The integrals from which the cost to go is least.", [z], ["begin"])))
    held = [z, integral] if ni else [z]
    parts.append(_law(part("law", "Inputs that lead to an equilibrium.", held, pushed)))
    if law.observer:
        parts.append(_expect(part("expect", "The deviation at the next call.", [z, ("u", nu)], ["rest", "advance", "drive"])))
    if ni:
        parts.append(_grow(part("grow", "The integrals at the next call.", [*held, y], ["offsets", *pushed])))
    return OutputTablePrograms({program.name: program for program in parts}, tuple(field for field in fields.values() if field.kept))


def _fields(table: OutputTable) -> dict[str, Field]:
    laws = table.laws
    each: dict[str, Callable[[int], Matrix]] = {
        "offsets": lambda k: (laws[k].offsets,), "rest": lambda k: (laws[k].rest,), "gains": lambda k: laws[k].gains,
        "integral_gains": lambda k: laws[k].integral_gains, "shape": lambda k: table.shapes[k], "begin": lambda k: table.begins[k],
    }  # fmt: skip
    if table.kind:
        for name in ("start", "seen", "correction", "advance", "drive"):
            each[name] = lambda k, name=name: getattr(laws[k].observer, name)  # type: ignore[misc]
    return {name: Field.of(name, [made(k) for k in range(len(laws))]) for name, made in each.items()}


def _apart(part: _Part) -> Program:
    total = part.builder.lift(0)
    for away in part.off(part.table.compared).values():
        total = total + away * away
    return part.finish("apart", [total], scalar=True)


def _start(part: _Part) -> Program:
    off = [finite(value) for value in part.off().values()]
    return part.finish("z", [part.product("start", i, off) for i in range(len(part.law.deviation_names))])


def _estimate(part: _Part) -> Program:
    law, off = part.law, list(part.off(wraps=part.law.observer is None).values())
    if law.observer is None:
        return part.finish("z", off)
    expected = [part.given["expected"][i] for i in range(len(law.deviation_names))]
    innovations = []
    for i, (name, value, turns) in enumerate(zip(law.measured_names, off, law.wraps, strict=True)):
        apart = value - part.product("seen", i, expected)
        innovations.append(part.builder.let(f"{name}_innovation", finite(wrapped(apart, full_turn()) if turns else apart)))
    found = []
    for i, turns in enumerate(law.turns):
        value = part.builder.let(f"{law.deviation_names[i]}_estimate", expected[i] + part.product("correction", i, innovations))
        found.append(wrapped(value, full_turn()) if turns else value)
    return part.finish("z", found)


def _level(part: _Part) -> Program:
    z, total = [part.given["z"][i] for i in range(len(part.law.deviation_names))], part.builder.lift(0)
    for i in range(len(part.table.shapes[0])):
        value = part.builder.let(f"part_{i + 1}", part.product("shape", i, z))
        total = total + value * value
    return part.finish("level", [total], scalar=True)


def _begin(part: _Part) -> Program:
    z = [part.given["z"][i] for i in range(len(part.law.deviation_names))]
    return part.finish("integral", [part.product("begin", k, z) for k in range(len(part.law.integrated))])


def _law(part: _Part) -> Program:
    return part.finish("u", [limited(u, *bounds) for u, *bounds in zip(part.wanted(), part.law.low, part.law.high, strict=True)])


def _expect(part: _Part) -> Program:
    law = part.law
    z = [part.given["z"][i] for i in range(len(law.deviation_names))]
    pushed = [part.given["u"][j] - part.entry("rest", 0, j) for j in range(len(law.input_names))]
    return part.finish("expected", [part.product("advance", i, z) + part.product("drive", i, pushed) for i in range(len(z))])


def _grow(part: _Part) -> Program:
    law, wanted = part.law, part.wanted()
    u = [limited(value, *bounds) for value, *bounds in zip(wanted, law.low, law.high, strict=True)]
    off, found = part.off(law.integrated), []
    for k, i in enumerate(law.integrated):
        gains = [part.entry("integral_gains", row, k) for row in range(len(u))]
        grows = grown(law, law.sample * finite(off[i]), gains, wanted, u)
        found.append(part.given["integral"][k] + grows)
    return part.finish("integral_next", found)
