"""Columns of spatial derivatives side by side: one vector each, which goes over the links."""

from __future__ import annotations

from phichain.ir.builder import Builder, Index
from phichain.lowering.algebra.vector import Vector


class Lanes:
    """As many vectors as there are columns, one row of cells for each component, written anew on every link."""

    def __init__(self, builder: Builder, name: str, width: int, components: str) -> None:
        self.cells = [builder.array(f"{name}_{component}", width) for component in components]

    def put(self, column: Index, value: Vector) -> None:
        """Write a column whose value is computed."""
        for cells, entry in zip(self.cells, value, strict=True):
            cells[column] = entry

    def at(self, column: Index) -> Vector:
        """The vector of a column."""
        return tuple(cells[column] for cells in self.cells)
