"""Handles on the values of a Program being written: scalars with arithmetic, arrays with cells, loops with carried scalars."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Protocol

from phichain.ir.nodes import Affine, Const, Local, Operand

Number = int | float | Fraction
Index = int | Affine


class Recorder(Protocol):
    """What records the operations of handles: a `Builder`."""

    def apply(self, kind: str, *args: Expr | Number, label: str = "") -> Expr: ...
    def lift(self, value: Expr | Number) -> Expr: ...
    def let(self, label: str, value: Expr) -> Expr: ...
    def read(self, array: str, index: Index) -> Expr: ...
    def write(self, array: str, index: Index, value: Expr | Number) -> None: ...


@dataclass(frozen=True, slots=True, eq=False)
class Expr:
    """A scalar being computed; arithmetic on it records operations in its Builder."""

    builder: Recorder
    operand: Operand

    def __add__(self, other: Expr | Number) -> Expr:
        return self.builder.apply("add", self, other)

    def __radd__(self, other: Number) -> Expr:
        return self.builder.apply("add", other, self)

    def __sub__(self, other: Expr | Number) -> Expr:
        return self.builder.apply("sub", self, other)

    def __rsub__(self, other: Number) -> Expr:
        return self.builder.apply("sub", other, self)

    def __mul__(self, other: Expr | Number) -> Expr:
        return self.builder.apply("mul", self, other)

    def __rmul__(self, other: Number) -> Expr:
        return self.builder.apply("mul", other, self)

    def __truediv__(self, other: Expr | Number) -> Expr:
        return self.builder.apply("div", self, other)

    def __rtruediv__(self, other: Number) -> Expr:
        return self.builder.apply("div", other, self)

    def __neg__(self) -> Expr:
        return self.builder.apply("neg", self)

    @property
    def constant(self) -> Fraction | None:
        """The exact value when it is known at generation time."""
        return self.operand.value if isinstance(self.operand, Const) else None

    @property
    def is_zero(self) -> bool:
        """True for a structural zero."""
        return self.constant == 0


@dataclass(frozen=True, slots=True, eq=False)
class ArrayRef:
    """A named array: ``ref[k]`` reads a cell, ``ref[k] = value`` writes one."""

    builder: Recorder
    name: str
    size: int
    offset: Index = 0
    stride: int = 1

    def __getitem__(self, index: Index) -> Expr:
        return self.builder.read(self.name, self._cell(index))

    def __setitem__(self, index: Index, value: Expr | Number) -> None:
        self.builder.write(self.name, self._cell(index), value)

    def _cell(self, index: Index) -> Index:
        return index * self.stride + self.offset

    def shifted(self, offset: Index, stride: int = 1) -> ArrayRef:
        """The same array from another origin and with another stride: ``ref.shifted(o, s)[k]`` is ``ref[o + s k]``."""
        return ArrayRef(self.builder, self.name, self.size, self._cell(offset), self.stride * stride)


class LoopRecorder(Recorder, Protocol):
    """What a loop being written wants of its Builder, too."""

    def fresh(self, name: str) -> str: ...
    def hoist(self, operand: Operand) -> None: ...


class Loop:
    """The loop being written: its index and its carried scalars."""

    def __init__(self, builder: LoopRecorder, variable: str) -> None:
        self._builder = builder
        self.index = Affine(0, ((variable, 1),))
        self.carries: dict[str, list[Operand]] = {}

    def carry(self, name: str, initial: Expr | Number) -> Expr:
        """A scalar with this value on the first turn; `follow` says what the next turn sees."""
        local = Local(self._builder.fresh(name))
        start = self._builder.lift(initial).operand
        self._builder.hoist(start)
        self.carries[local.name] = [start, local]
        return Expr(self._builder, local)

    def follow(self, carried: Expr, value: Expr | Number) -> None:
        """Set what the next turn (and the code after the loop) sees for a carried scalar."""
        assert isinstance(carried.operand, Local)
        self.carries[carried.operand.name][1] = self._builder.lift(value).operand
