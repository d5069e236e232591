"""One Program as the body of one Python function over lists of scalars that know arithmetic.

Arrays are flat lists, scalar arguments and results plain names. Elementary functions come from the module `casadi`, which
takes numbers and expressions alike.
"""

from __future__ import annotations

import keyword
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction

from phichain.emit.expressions import Text, double_literal, infix
from phichain.emit.inlining import used_once
from phichain.ir.nodes import Call, Cell, Const, For, Local, Op, Operand, Program, SinCos, Statement, Store

#: Longest expression that is written in place instead of getting a name.
_LONGEST = 72

#: Names the printed body relies on; a quantity of the same name gives way.
_TAKEN = frozenset({"angle", "bessel", "casadi", "range", "None"})

Table = tuple[str, tuple[Fraction, ...]]


@dataclass(frozen=True)
class PythonFunction:
    """The text of one function.

    Attributes:
        arguments: its arguments, runtime parameters first.
        lines: its body, indented by four spaces, the return statement last.
        uses_bessel: whether it calls ``bessel``.
    """

    arguments: tuple[str, ...]
    lines: tuple[str, ...]
    uses_bessel: bool


def python_function(
    program: Program, tables: Mapping[Table, str], callees: Mapping[str, str]
) -> PythonFunction:
    """Print a Program.

    Args:
        program: the function; straight-line or with loops.
        tables: module-level name of each table of constants, by its name and values.
        callees: Python name of every Program that this one calls; those take their runtime parameters first, too.
    """
    writer = _Writer(program, tables, callees)
    writer.arrays()
    writer.block(program.body, 1)
    writer.line(1, f"return {', '.join(spelt(array.name) for array in program.outputs)}")
    arguments = tuple(spelt(array.name) for array in (*program.params, *program.inputs))
    return PythonFunction(arguments, tuple(writer.lines), writer.uses_bessel)


def spelt(name: str) -> str:
    """A quantity's name as a Python name."""
    return f"{name}_" if keyword.iskeyword(name) or name in _TAKEN else name


class _Writer:
    def __init__(self, program: Program, tables: Mapping[Table, str], callees: Mapping[str, str]) -> None:
        self.program, self.callees = program, callees
        self.lines: list[str] = []
        self.texts: dict[str, Text] = {}
        self.in_place = used_once(program.body)
        arguments = (*program.params, *program.inputs)
        self.sizes = {array.name: array.size for array in (*arguments, *program.outputs, *program.work)}
        self.scalars = {array.name for array in (*arguments, *program.outputs) if array.shape == ()}
        self.tables = {name: tables[name, values] for name, values in program.tables.items()}
        self.bessel_calls: dict[str, str] = {}
        self.uses_bessel = False
        self.fresh = 0

    def line(self, depth: int, text: str) -> None:
        self.lines.append("    " * depth + text)

    def arrays(self) -> None:
        """Room for what is filled cell by cell; None, so that reading too early fails."""
        made_whole = {name for s in self.program.body for name in self.filled(s)} | self.scalars
        for array in (*self.program.work, *self.program.outputs):
            if array.name not in made_whole:
                self.line(1, f"{spelt(array.name)} = [None] * {array.size}")

    def filled(self, statement: Statement) -> tuple[str, ...]:
        """The arrays that a statement makes as a whole."""
        match statement:
            case Call(outputs=outputs):
                return outputs
            case SinCos(sine, cosine, count=count):
                return tuple(name for name in (sine, cosine) if self.sizes[name] == count)
        return ()

    # --- statements -------------------------------------------------------------------------------------------------

    def block(self, statements: tuple[Statement, ...], depth: int) -> None:
        outside, self.bessel_calls = self.bessel_calls, {}
        for statement in statements:
            self.statement(statement, depth)
        self.bessel_calls = outside

    def statement(self, statement: Statement, depth: int) -> None:
        match statement:
            case Op(kind=kind) if kind.startswith("besselj"):
                self.bessel(statement, depth)
            case Op():
                self.op(statement, depth)
            case Store(cell, value):
                self.line(depth, f"{self.target(cell)} = {self.operand(value).text}")
            case SinCos():
                self.sincos(statement, depth)
            case For():
                self.loop(statement, depth)
            case Call(callee, inputs, outputs):
                params = self.program.callees[callee].params
                names = [*(array.name for array in params), *inputs]
                call = f"{self.callees[callee]}({', '.join(map(spelt, names))})"
                self.line(depth, f"{', '.join(map(spelt, outputs))} = {call}")

    def op(self, op: Op, depth: int) -> None:
        text = self.expression(op)
        if op.result in self.in_place and len(text.text) <= _LONGEST:
            self.texts[op.result] = text
            return
        name = self.anonymous("t") if op.result.startswith("_") else spelt(op.result)
        self.line(depth, f"{name} = {text.text}")
        self.texts[op.result] = Text(name)

    def expression(self, op: Op) -> Text:
        args = [self.operand(arg) for arg in op.args]
        if op.kind == "select":
            a, b, below, above = (arg.text for arg in args)
            return Text(f"casadi.if_else({a} < {b}, {below}, {above})")
        return infix(op.kind, args) or Text(f"casadi.{op.kind}({args[0].text})")

    def bessel(self, op: Op, depth: int) -> None:
        """J_0 to J_4 of one argument come from one call a block."""
        self.uses_bessel = True
        argument = self.operand(op.args[0]).text
        if argument not in self.bessel_calls:
            self.bessel_calls[argument] = self.anonymous("bessel_")
            self.line(depth, f"{self.bessel_calls[argument]} = bessel({argument})")
        self.texts[op.result] = Text(f"{self.bessel_calls[argument]}[{op.kind[-1]}]")

    def sincos(self, statement: SinCos, depth: int) -> None:
        stop = statement.offset + statement.count
        angles = spelt(statement.angle)
        if (statement.offset, stop) != (0, self.sizes.get(statement.angle)):
            angles = f"{angles}[{statement.offset}:{stop}]"
        for name, function in ((statement.sine, "sin"), (statement.cosine, "cos")):
            place = "" if name in self.filled(statement) else f"[:{statement.count}]"
            self.line(depth, f"{spelt(name)}{place} = [casadi.{function}(angle) for angle in {angles}]")

    def loop(self, loop: For, depth: int) -> None:
        for carry in loop.carries:
            self.texts[carry.name] = Text(spelt(carry.name))
            self.line(depth, f"{spelt(carry.name)} = {self.operand(carry.initial).text}")
        bounds = [str(loop.start), str(loop.stop), str(loop.step)]
        shown = bounds if loop.step != 1 else bounds[1:2] if bounds[0] == "0" else bounds[:2]
        head = len(self.lines)
        self.line(depth, f"for {loop.variable} in range({', '.join(shown)}):")
        self.block(loop.body, depth + 1)
        self.advance(loop, depth + 1)
        if len(self.lines) == head + 1:  # nothing happens in it
            self.lines.pop()

    def advance(self, loop: For, depth: int) -> None:
        """Carried scalars move on together."""
        moves = [(c.name, c.following) for c in loop.carries if c.following != Local(c.name)]
        names = [spelt(name) for name, _ in moves]
        values = [self.operand(following).text for _, following in moves]
        if any(_mentions(text, name) for i, name in enumerate(names) for text in values[i + 1 :]):
            self.line(depth, f"{', '.join(names)} = {', '.join(values)}")
            return
        for name, text in zip(names, values, strict=True):
            self.line(depth, f"{name} = {text}")

    # --- operands ---------------------------------------------------------------------------------------------------

    def operand(self, operand: Operand) -> Text:
        if isinstance(operand, Const):
            return double_literal(operand.value)
        if isinstance(operand, Local):
            return self.texts[operand.name]
        return Text(self.target(operand))

    def target(self, cell: Cell) -> str:
        name = self.tables.get(cell.array) or spelt(cell.array)
        return name if cell.array in self.scalars else f"{name}[{cell.index}]"

    def anonymous(self, stem: str) -> str:
        self.fresh += 1
        return f"{stem}{self.fresh}"


def _mentions(text: str, name: str) -> bool:
    return name in "".join(c if c.isidentifier() or c.isdigit() else " " for c in text).split()
