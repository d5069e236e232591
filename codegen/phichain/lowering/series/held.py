"""Where the constants of a step sit in the array that `factor` fills and `order` reads."""

from __future__ import annotations

from collections.abc import Iterable

from phichain.ir.builder import ArrayRef


class Layout:
    """Named runs of cells, one after the other; what a scene does not need has no place."""

    def __init__(self, runs: Iterable[tuple[str, int]]) -> None:
        """Place the runs (name, count); those of no cells are left out."""
        self._starts: dict[str, int] = {}
        self.size = 0
        for name, count in runs:
            if count:
                self._starts[name] = self.size
                self.size += count

    def __contains__(self, name: str) -> bool:
        return name in self._starts

    def of(self, held: ArrayRef, name: str) -> ArrayRef:
        """The cells of one run, counted from 0."""
        return held.shifted(self._starts[name])
