"""What the recurrences of a Program are made of: the lanes of its products, and values along a series."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Final

from phichain.ir.builder import Expr
from phichain.ir.nodes import Affine, Array, For, Operand, Program

#: Arrays of the two Programs: the lanes' rows, and values that do not vary in time.
LEFT: Final = "jet_left"
RIGHT: Final = "jet_right"
HELD: Final = "jet_held"
#: What `follow` sees of order 0 (suffix), the sums S_n, and the order itself.
FIRST: Final = "_0"
SUMS: Final = "jet_sum"
ORDER: Final = "jet_order"
INVERSE_ORDER: Final = "jet_inverse_order"


@dataclass(frozen=True)
class Jets:
    """The Taylor recurrences of a Program.

    Attributes:
        start: inputs and outputs of the Program at order 0, and the first rows of the lanes that are there.
        follow: the moving inputs' coefficients of order n >= 1 -> the outputs' coefficients, and the lanes' rows.
        products: number of lanes.
        held: values that do not vary in time, computed once by `start`.
    """

    start: Program
    follow: Program
    products: int
    held: int


@dataclass(frozen=True, slots=True)
class Value:
    """A scalar: its value at order 0, and its coefficient of order n (None where it does not vary)."""

    start: Expr
    rate: Expr | None
    operand: Operand


@dataclass
class Cells:
    """Cells handed out to operations, a run of them for an operation inside loops."""

    used: int = 0

    def take(self, nest: tuple[For, ...]) -> Affine:
        """The cell of this turn of the loops around."""
        index, stride = Affine(0), 1
        for loop in reversed(nest):
            low, high = loop.hull
            index = index + stride * Affine(-low, ((loop.variable, 1),))
            stride *= max(high - low + 1, 1)
        index, self.used = index + self.used, self.used + stride
        return index


@dataclass
class Counts:
    """What has been handed out so far."""

    products: Cells = field(default_factory=Cells)
    held: Cells = field(default_factory=Cells)


@dataclass(frozen=True, slots=True)
class Lane:
    """A product's lane as `follow` sees it: where, its factors' first coefficients, and its sum S_n."""

    place: Affine
    left: Expr
    right: Expr
    total: Expr


def sized(program: Program, sizes: dict[str, int]) -> Program:
    """The Program with the sizes of its lanes, now that they are known; arrays without cells are left out."""

    def resized(arrays: tuple[Array, ...]) -> tuple[Array, ...]:
        known = (replace(a, shape=(sizes[a.name],)) if a.name in sizes else a for a in arrays)
        return tuple(array for array in known if array.size)

    return replace(program, inputs=resized(program.inputs), outputs=resized(program.outputs))
