"""Programs on pairs of numbers, each a value and what rounding took from it: what a step's rounding errors are known by, with their signs.

`stencils/beside/pairs.c` has the arithmetic. What is printed here is for the compiled object alone and read by nobody who writes firmware, so
that every operation stands on a line of its own.
"""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from typing import Final

from phichain.emit.c.names import CNames
from phichain.emit.flow.instance import Part
from phichain.ir.nodes import Cell, Const, For, Local, Op, Operand, Program, SinCos, Statement, Store, walk
from phichain.ir.rounded import nearest
from phichain.lowering.series.series import (
    COEFFICIENT,
    HELD,
    LEFT,
    LOST,
    NEWEST,
    NEXT,
    NOW,
    RIGHT,
    SCALE,
    SUMS,
    Series,
)
from phichain.scene import Scene

_CALLS: Final = {"add": "add", "sub": "subtract", "mul": "multiply", "div": "divide", "neg": "negative"}
#: What the two functions take and give, whatever a scene has of it.
_FACTOR: Final = (("q", "v", "u", SCALE, LOST), (HELD, LEFT, RIGHT))
_ORDER: Final = ((HELD, SUMS, NEWEST, COEFFICIENT, NOW), (LEFT, RIGHT, NEXT))


def knows_rounding(scene: Scene, made: Series) -> bool:
    """Whether the recurrences of a scene can be run on pairs: those in the plane, in double precision and without dry friction, whose tanh has no pair."""
    kinds = {statement.kind for program in (made.factor, made.order) for statement in walk(program.body) if isinstance(statement, Op)}
    return scene.is_planar and scene.real == "double" and not made.dry and not made.is_forced and kinds <= {*_CALLS, "sin", "cos", "select"}


def pair_functions(scene: Scene, made: Series, names: CNames, stem: str) -> list[Part]:
    """`factor` and `order` on pairs, as static functions."""
    return [
        _part(scene, program, names, stem, arguments)
        for program, arguments in ((made.factor, _FACTOR), (made.order, _ORDER))
    ]


def _part(scene: Scene, program: Program, names: CNames, stem: str, arguments: tuple[tuple[str, ...], tuple[str, ...]]) -> Part:
    given, results = arguments
    writer = _Writer(program, names, stem)
    lines = (*writer.arrays(), *writer.block(program.body, 1))
    declared = [f"const {scene.name}_params *p"] if scene.runtime else []
    declared += [f"const {stem}_pair *{name}" for name in given] + [f"{stem}_pair *{scene.name.upper()}_RESTRICT {name}" for name in results]
    used = {cell.array for statement in walk(program.body) for cell in _cells(statement)}
    ignored = [name for name in given if name not in used] + (["p"] if scene.runtime and not used & {array.name for array in program.params} else [])
    symbol = f"{stem}_{program.name.removeprefix('flow_')}_pairs"
    return Part((f"/* {program.doc} On pairs. */",), symbol, ", ".join(declared), tuple(ignored), tuple(lines))


def _cells(statement: Statement) -> Iterator[Cell]:
    """The cells that a statement names."""
    match statement:
        case Op(args=operands):
            pass
        case Store(cell, value):
            operands = (cell, value)
        case For(carries=carries):
            operands = tuple(operand for carry in carries for operand in (carry.initial, carry.following))
        case SinCos(angle=angle):
            operands = (Cell(angle, 0),)  # type: ignore[arg-type]
        case _:
            operands = ()
    yield from (operand for operand in operands if isinstance(operand, Cell))


class _Writer:
    """Prints the statements of one Program."""

    def __init__(self, program: Program, names: CNames, stem: str) -> None:
        self.program, self.names, self.stem = program, names, stem
        self.params = {array.name: array for array in program.params}
        #: Texts of sines and cosines, the numbers of their angles in the block that is written, and how many there were.
        self.texts: dict[str, str] = {}
        self.angles: dict[Operand, int] = {}
        self.count = 0

    def arrays(self) -> Iterator[str]:
        for name, values in self.program.tables.items():
            yield f"    static const {self.stem}_pair {name}[{len(values)}] = {{{', '.join(self.literal(value) for value in values)}}};"
        for array in self.program.work:
            yield f"    {self.stem}_pair {array.name}[{array.size}];"

    def block(self, statements: tuple[Statement, ...], depth: int) -> Iterator[str]:
        pad = "    " * depth
        for statement in statements:
            match statement:
                case Op(result, kind, args):
                    yield from self.op(pad, result, kind, args)
                case Store(cell, value):
                    yield f"{pad}{self.cell(cell)} = {self.operand(value)};"
                case SinCos(sine, cosine, angle, offset, count):
                    yield f"{pad}for (int at = 0; at < {count}; ++at) {{"
                    yield f"{pad}    {self.stem}_sine_cosine(&{angle}[{offset} + at], &{sine}[at], &{cosine}[at]);"
                    yield f"{pad}}}"
                case For():
                    yield from self.loop(statement, depth)

    def op(self, pad: str, result: str, kind: str, args: tuple[Operand, ...]) -> Iterator[str]:
        if kind in ("sin", "cos"):
            yield from self.turned(pad, args[0])
            self.texts[result] = f"{'sine' if kind == 'sin' else 'cosine'}{self.angles[args[0]]}"
            return
        if kind == "select":
            a, b, below, above = (self.operand(arg) for arg in args)
            text = f"({a}).value < ({b}).value ? {below} : {above}"
        else:
            text = f"{self.stem}_{_CALLS[kind]}({', '.join(self.operand(arg) for arg in args)})"
        yield f"{pad}const {self.stem}_pair {self.local(result)} = {text};"

    def turned(self, pad: str, angle: Operand) -> Iterator[str]:
        """Sine and cosine of an angle, where they are not there yet."""
        if angle in self.angles:
            return
        self.count += 1
        number = self.angles[angle] = self.count
        yield f"{pad}const {self.stem}_pair angle{number} = {self.operand(angle)};"
        yield f"{pad}{self.stem}_pair sine{number}, cosine{number};"
        yield f"{pad}{self.stem}_sine_cosine(&angle{number}, &sine{number}, &cosine{number});"

    def loop(self, loop: For, depth: int) -> Iterator[str]:
        pad, variable = "    " * depth, loop.variable
        for carry in loop.carries:
            yield f"{pad}{self.stem}_pair {self.local(carry.name)} = {self.operand(carry.initial)};"
        condition, advance = (f"< {loop.stop}", "++") if loop.step > 0 else (f">= {loop.stop + 1}", "--")
        yield f"{pad}for (int {variable} = {loop.start}; {variable} {condition}; {advance}{variable}) {{"
        outside, self.angles = self.angles, {}
        yield from self.block(loop.body, depth + 1)
        self.angles = outside
        for number, carry in enumerate(loop.carries):
            yield f"{pad}    const {self.stem}_pair following{number} = {self.operand(carry.following)};"
        for number, carry in enumerate(loop.carries):
            yield f"{pad}    {self.local(carry.name)} = following{number};"
        yield f"{pad}}}"

    def local(self, name: str) -> str:
        return self.texts.get(name) or (f"x{name}" if name.startswith("_") else f"x_{name}")

    def cell(self, cell: Cell) -> str:
        return f"{cell.array}[{cell.index}]"

    def operand(self, operand: Operand) -> str:
        if isinstance(operand, Const):
            return f"(({self.stem}_pair){self.literal(operand.value)})"
        if isinstance(operand, Local):
            return self.local(operand.name)
        if operand.array in self.params:
            own = f"p->{operand.array}" + ("" if self.params[operand.array].shape == () else f"[{operand.index}]")
            return f"(({self.stem}_pair){{{own}, 0}})"
        return self.cell(operand)

    def literal(self, value: Fraction) -> str:
        """An exact number as a pair."""
        near = Fraction(nearest("double", value))
        return f"{{{self.names.number(near).text}, {self.names.number(value - near).text}}}"
