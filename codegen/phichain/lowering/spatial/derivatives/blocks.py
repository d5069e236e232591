"""3 x 3 blocks of results, and what they are made of."""

from __future__ import annotations

from dataclasses import dataclass

from phichain.ir.builder import ArrayRef, Index
from phichain.lowering.algebra.vector import Vector, add

Rows = tuple[Vector, ...]


@dataclass(frozen=True)
class Blocks:
    """3 x 3 blocks of a matrix of results, counted in links."""

    array: ArrayRef
    first: int
    width: int

    def put(self, i: Index, j: Index, rows: Rows) -> None:
        """Block (i, j)."""
        for r, row in enumerate(rows):
            for c, value in enumerate(row):
                self.array[(3 * i + (r + self.first)) * self.width + 3 * j + (c + self.first)] = value


def dyad(a: Vector, b: Vector) -> Rows:
    """a b^T."""
    return tuple(tuple(x * y for y in b) for x in a)


def hat(a: Vector) -> Rows:
    """The matrix of a x."""
    x, y, z = a
    nothing = x.builder.lift(0)
    return (nothing, -z, y), (z, nothing, -x), (-y, x, nothing)


def plus(a: Rows, b: Rows) -> Rows:
    """a + b."""
    return tuple(add(x, y) for x, y in zip(a, b, strict=True))
