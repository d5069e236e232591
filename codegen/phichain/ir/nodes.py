"""The intermediate representation: a plain list of small operations with named inputs and outputs.

A `Program` computes its output arrays from its input arrays. Its body is a tuple of statements:

- ``Op``      one scalar operation, ``result = kind(args)``; results are assigned once;
- ``Store``   one cell of a work or output array, written once per call;
- ``SinCos``  sines and cosines of a run of cells, always paired, so that a backend can vectorise them;
- ``For``     a counted loop with explicit loop-carried scalars (as in a functional scan);
- ``Call``    another Program of the same scene, arrays in, arrays out.

A straight-line Program holds no ``For`` and no ``Call``. Numbers are exact rationals until a backend prints them, so the
same Program serves the 50-digit oracle and single-precision C alike.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from fractions import Fraction
from html import escape


@dataclass(frozen=True, slots=True)
class Const:
    """An exact number; rounded once, when a backend prints or evaluates it."""

    value: Fraction

    def __hash__(self) -> int:
        return hash(self.value.numerator) ^ self.value.denominator


@dataclass(frozen=True, slots=True)
class Affine:
    """An integer index ``offset + sum(coefficient * loop variable)``."""

    offset: int = 0
    terms: tuple[tuple[str, int], ...] = ()

    def __add__(self, other: Affine | int) -> Affine:
        if isinstance(other, int):
            return Affine(self.offset + other, self.terms)
        merged = dict(self.terms)
        for variable, coefficient in other.terms:
            merged[variable] = merged.get(variable, 0) + coefficient
        return Affine(self.offset + other.offset, tuple((v, c) for v, c in sorted(merged.items()) if c))

    __radd__ = __add__

    def __mul__(self, factor: int) -> Affine:
        return Affine(self.offset * factor, tuple((v, c * factor) for v, c in self.terms) if factor else ())

    __rmul__ = __mul__

    def __neg__(self) -> Affine:
        return self * -1

    def __sub__(self, other: Affine | int) -> Affine:
        return self + (-other)

    def __rsub__(self, other: int) -> Affine:
        return -self + other

    def at(self, indices: dict[str, int]) -> int:
        """The integer this index has where the loop variables have the given values."""
        return self.offset + sum(coefficient * indices[variable] for variable, coefficient in self.terms)

    def __str__(self) -> str:
        pieces = [(c, v if abs(c) == 1 else f"{abs(c)} * {v}") for v, c in self.terms]
        if self.offset or not pieces:
            pieces.append((self.offset, str(abs(self.offset))))
        pieces.sort(key=lambda piece: piece[0] < 0)
        first = f"{'-' if pieces[0][0] < 0 else ''}{pieces[0][1]}"
        return first + "".join(f" {'-' if c < 0 else '+'} {text}" for c, text in pieces[1:])


@dataclass(frozen=True, slots=True)
class Cell:
    """One element of an array (row-major, flattened)."""

    array: str
    index: Affine


@dataclass(frozen=True, slots=True)
class Local:
    """The result of an `Op`, or a loop-carried scalar."""

    name: str

    def __hash__(self) -> int:
        return hash(self.name)


Operand = Const | Cell | Local


@dataclass(frozen=True, slots=True)
class Op:
    """``result = kind(*args)``; kinds: add, sub, mul, div of two, neg, sqrt, sin, cos, tanh, floor, besselj0 to besselj4 of
    one, select(a, b, x, y) that is x where a < b, else y.
    """

    result: str
    kind: str
    args: tuple[Operand, ...]


@dataclass(frozen=True, slots=True)
class Store:
    """``cell = value``."""

    cell: Cell
    value: Operand


@dataclass(frozen=True, slots=True)
class SinCos:
    """``sine[i], cosine[i] = sin(angle[offset + i]), cos(angle[offset + i])`` for i below count."""

    sine: str
    cosine: str
    angle: str
    offset: int
    count: int


@dataclass(frozen=True, slots=True)
class Carry:
    """A loop-carried scalar: `initial` before the first turn, `following` after each; the last one stays visible."""

    name: str
    initial: Operand
    following: Operand


@dataclass(frozen=True, slots=True)
class For:
    """``for variable = start, start + step, ... short of stop`` (step is +1 or -1).

    `hull` holds the least and the greatest value of the variable over all turns of the loops around it. The turns of lanes
    carry nothing and stand side by side, for a backend to do them at once.
    """

    variable: str
    start: Affine
    stop: Affine
    step: int
    carries: tuple[Carry, ...]
    body: tuple[Statement, ...]
    hull: tuple[int, int]
    is_lanes: bool = False

    def range(self, indices: dict[str, int]) -> range:
        """The values the loop variable takes where the outer loop variables have the given values."""
        return range(self.start.at(indices), self.stop.at(indices), self.step)


@dataclass(frozen=True, slots=True)
class Call:
    """Another Program of the scene, applied to whole arrays of this one."""

    callee: str
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]


Statement = Op | Store | SinCos | For | Call


@dataclass(frozen=True, slots=True)
class Array:
    """A named array argument or work array; shape () is a scalar."""

    name: str
    shape: tuple[int, ...]
    doc: str = ""

    @property
    def size(self) -> int:
        """Number of elements."""
        size = 1
        for extent in self.shape:
            size *= extent
        return size


@dataclass(frozen=True)
class Program:
    """One function of a scene as data: arguments, tables of exact constants, work arrays and statements."""

    name: str
    doc: str
    params: tuple[Array, ...]
    inputs: tuple[Array, ...]
    outputs: tuple[Array, ...]
    work: tuple[Array, ...]
    tables: dict[str, tuple[Fraction, ...]]
    body: tuple[Statement, ...]
    callees: dict[str, Program] = field(default_factory=dict)

    @property
    def is_straight_line(self) -> bool:
        """True when the body holds neither loops nor calls."""
        return not any(isinstance(statement, For | Call) for statement in self.body)

    def __str__(self) -> str:
        head = f"{self.name}({', '.join(a.name for a in self.inputs)}) -> {', '.join(a.name for a in self.outputs)}"
        return "\n".join([head, *_lines(self.body, 1)])

    def _repr_html_(self) -> str:
        return f"<pre>{escape(str(self))}</pre>"


def walk(statements: tuple[Statement, ...]) -> Iterator[Statement]:
    """Every statement, loops before their bodies."""
    for statement in statements:
        yield statement
        if isinstance(statement, For):
            yield from walk(statement.body)


def show_operand(operand: Operand) -> str:
    """How `print(program)` writes an operand."""
    if isinstance(operand, Const):
        return f"{float(operand.value):.17g}"
    return operand.name if isinstance(operand, Local) else f"{operand.array}[{operand.index}]"


def _lines(statements: tuple[Statement, ...], depth: int) -> Iterator[str]:
    pad = "  " * depth
    for statement in statements:
        match statement:
            case Op(result, kind, args):
                yield f"{pad}{result} = {kind}({', '.join(map(show_operand, args))})"
            case Store(cell, value):
                yield f"{pad}{show_operand(cell)} = {show_operand(value)}"
            case SinCos(sine, cosine, angle, offset, count):
                yield f"{pad}{sine}, {cosine} = sincos({angle}[{offset}:{offset + count}])"
            case Call(callee, inputs, outputs):
                yield f"{pad}{', '.join(outputs)} = {callee}({', '.join(inputs)})"
            case For(variable, start, stop, step, carries, body):
                yield f"{pad}for {variable} in range({start}, {stop}, {step}):"
                for carry in carries:
                    yield f"{pad}  carry {carry.name}: {show_operand(carry.initial)} -> {show_operand(carry.following)}"
                yield from _lines(body, depth + 1)
