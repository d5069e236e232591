"""3 x 3 blocks of results."""

from __future__ import annotations

from dataclasses import dataclass

from phichain.ir.builder import ArrayRef, Expr, Index
from phichain.lowering.algebra.matrix import Matrix


@dataclass
class Blocks:
    """3 x 3 blocks of a matrix of results, counted in links."""

    array: ArrayRef
    first: int
    width: int

    def put(self, i: Index, j: Index, rows: Matrix) -> None:
        """Block (i, j)."""
        for r, row in enumerate(rows):
            for c, value in enumerate(row):
                self.array[(3 * i + (r + self.first)) * self.width + 3 * j + (c + self.first)] = value

    def entry(self, row: Index, column: Index, value: Expr) -> None:
        """One entry, counted from the first link's on."""
        self.array[(row + self.first) * self.width + column + self.first] = value
