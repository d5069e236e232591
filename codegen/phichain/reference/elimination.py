"""Gaussian elimination on sparse rows: columns in order, pivots by size; it knows nothing of chains.

A row takes part from its first column on, so that a banded matrix of n rows costs O(n) operations.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from phichain.errors import ConvergenceError
from phichain.reference.algebra import Vector

Row = dict[int, Any]


@dataclass(frozen=True)
class Factored:
    """A matrix as triangular factors.

    Attributes:
        steps: for every column the row that serves it, and (row, factor) of those from which it was taken.
        upper: the rows that were left, one a column.
    """

    steps: Sequence[tuple[int, Sequence[tuple[int, Any]]]]
    upper: Sequence[Mapping[int, Any]]

    def solve(self, right: Vector) -> Vector:
        """Return x of matrix x = right."""
        values = list(right)
        for pivot, taken in self.steps:
            for row, factor in taken:
                values[row] -= factor * values[pivot]
        x: Vector = [0] * len(values)
        for column in reversed(range(len(values))):
            entries, value = self.upper[column], values[self.steps[column][0]]
            for other, entry in entries.items():
                if other != column:
                    value -= entry * x[other]
            x[column] = value / entries[column]
        return x


def factored(rows: Sequence[Row]) -> Factored:
    """Factor a square matrix, given by its rows as entries by column.

    Raises:
        ConvergenceError: it is singular.
    """
    waiting = sorted(range(len(rows)), key=lambda i: min(rows[i]), reverse=True)
    active: dict[int, Row] = {}
    steps, upper = [], []
    for column in range(len(rows)):
        while waiting and min(rows[waiting[-1]]) <= column:
            row = waiting.pop()
            active[row] = {i: entry for i, entry in rows[row].items() if entry}
        here = [row for row, entries in active.items() if column in entries]
        if not here:
            raise ConvergenceError("matrix", column, "is singular at this column", "pass a state that determines the motion")
        pivot = max(here, key=lambda row: abs(active[row][column]))
        leading = active.pop(pivot)
        taken = []
        for row in here:
            if row != pivot:
                factor = active[row].pop(column) / leading[column]
                _take(active[row], factor, leading, column)
                taken.append((row, factor))
        steps.append((pivot, taken))
        upper.append(leading)
    return Factored(steps, upper)


def _take(row: Row, factor: Any, leading: Mapping[int, Any], column: int) -> None:
    """Subtract a multiple of a row, but for a column that is done."""
    for i, entry in leading.items():
        if i == column:
            continue
        value = row[i] - factor * entry if i in row else -factor * entry
        if value:
            row[i] = value
        else:
            row.pop(i, None)
