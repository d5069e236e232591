"""Rows of work-precision tables, and the clock that fills them."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

from benchmarks.table import Table

ENOUGH = 5
"""Rounds after which a slow candidate is not tried again."""


@dataclass(frozen=True)
class Candidate:
    """Something to be timed.

    Attributes:
        method: Name of the curve it belongs to.
        setting: Its tolerance, step size or order, as text.
        own: Whether it is phichain's.
        solve: Does the work and returns what is compared.
        error: Of what `solve` returns.
        setup: Seconds from the description to something callable; NaN when not measured.
    """

    method: str
    setting: str
    own: bool
    solve: Callable[[], Any]
    error: Callable[[Any], float]
    setup: float = float("nan")


@dataclass(frozen=True)
class Row:
    """One (method, setting): its error and its time."""

    method: str
    setting: str
    own: bool
    error: float
    seconds: float
    setup: float
    note: str = ""


def measure(candidates: Sequence[Candidate], rounds: int, patience: float) -> list[Row]:
    """Time all candidates in turn, round after round; the least processor time of each counts.

    Processor time, because on a busy machine the wall clock is kind to whatever fits between two interruptions.

    Args:
        candidates: What to time; one that raises becomes a row without figures.
        rounds: At most so many.
        patience: Seconds after which a candidate is not tried again.
    """
    rows: list[Row | None] = [None] * len(candidates)
    spent = [0.0] * len(candidates)
    for _ in range(rounds):
        for k, candidate in enumerate(candidates):
            row = rows[k]
            if spent[k] > patience or (row is not None and row.note):
                continue
            if row is None:
                rows[k], spent[k] = _first(candidate)
                continue
            begin = time.process_time()
            candidate.solve()
            seconds = time.process_time() - begin
            spent[k] += seconds
            rows[k] = replace(row, seconds=min(row.seconds, seconds))
    return [row for row in rows if row is not None]


def _first(candidate: Candidate) -> tuple[Row, float]:
    plain = Row(
        candidate.method, candidate.setting, candidate.own, float("nan"), float("nan"), candidate.setup
    )
    begin = time.process_time()
    try:
        result = candidate.solve()
    except Exception as failure:  # noqa: BLE001 - a row says that it cannot
        words = str(failure).splitlines()[0] if str(failure) else type(failure).__name__
        return replace(plain, note=words[:120]), time.process_time() - begin
    seconds = time.process_time() - begin
    return replace(plain, seconds=seconds, error=candidate.error(result)), seconds


def best_time(rows: Sequence[Row], methods: Sequence[str], error: float) -> float | None:
    """The least time of some methods at no larger error; None where none is as accurate."""
    times = [row.seconds for row in rows if row.method in methods and row.error <= error]
    return min(times, default=None)


def ratio_cell(row: Row, rows: Sequence[Row], methods: Sequence[str]) -> str:
    """Time over the yardstick's at no larger error; against its most accurate row, marked, where none is as accurate."""
    if row.seconds != row.seconds:
        return "-"
    best = best_time(rows, methods, row.error)
    if best is not None:
        return f"{row.seconds / best:.3g}"
    known = [other for other in rows if other.method in methods and other.error == other.error]
    if not known:
        return "-"
    nearest = min(known, key=lambda other: other.error)
    return f"{row.seconds / nearest.seconds:.3g} (at its {nearest.error:.0e})"


def as_table(
    title: str,
    rows: Sequence[Row],
    yardsticks: dict[str, tuple[str, ...]],
    unit: tuple[str, float],
    notes: Sequence[str] = (),
) -> Table:
    """One table: method, setting, error, time, ratios, time from the description.

    Args:
        title: Heading.
        rows: All rows.
        yardsticks: Heading of a ratio -> the methods that serve as its yardstick.
        unit: Of the time: its name and seconds in it.
        notes: Below.
    """
    cells = []
    for row in rows:
        method = f"**{row.method}**" if row.own else row.method
        if row.note:
            cells.append((method, row.setting, "-", "-", *("-" for _ in yardsticks), row.note))
            continue
        ratios = (ratio_cell(row, rows, methods) for methods in yardsticks.values())
        setup = "" if row.setup != row.setup else f"{row.setup:.2f}"
        cells.append(
            (method, row.setting, f"{row.error:.1e}", f"{row.seconds / unit[1]:.4g}", *ratios, setup)
        )
    heads = ("method", "setting", "error", unit[0], *yardsticks, "s to something callable")
    return Table(title, heads, tuple(cells), tuple(notes))
