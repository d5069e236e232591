"""Perturbations of many columns side by side, on their way over the links: what Jacobians from one factorisation carry along."""

from __future__ import annotations

from collections.abc import Sequence

from phichain.ir.builder import Builder, Expr, Index


class Lanes:
    """States of columns: one row of cells a link, or two rows in turn for a long chain."""

    def __init__(self, builder: Builder, name: str, width: int, links: int, parts: Sequence[str], takes_turns: bool) -> None:
        self.width, self.takes_turns = width, takes_turns
        rows = 1 if takes_turns else links
        names = (f"{name}_even", f"{name}_odd") if takes_turns else (name,)
        self.cells = [tuple(builder.array(f"{row}_{part}", width * rows) for part in parts) for row in names]

    def put(self, row: Index, column: Index, value: Sequence[Expr]) -> None:
        for cells, entry in zip(self.cells[self._turn(row)], value, strict=True):
            cells[self._place(row, column)] = entry

    def at(self, row: Index, column: Index) -> tuple[Expr, ...]:
        place = self._place(row, column)
        return tuple(cells[place] for cells in self.cells[self._turn(row)])

    def _turn(self, row: Index) -> int:
        """Rows that loops count step by two links, so that their offset tells even from odd."""
        return (row if isinstance(row, int) else row.offset) % 2 if self.takes_turns else 0

    def _place(self, row: Index, column: Index) -> Index:
        return column if self.takes_turns else row * self.width + column
