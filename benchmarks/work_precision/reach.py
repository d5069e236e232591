"""The ratios people ask for first, out of the rows of one run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from benchmarks.table import Table
from benchmarks.work_precision.integrators import TAYLOR
from benchmarks.work_precision.problems import problems
from benchmarks.work_precision.rows import Row, best_time
from phichain import build
from phichain.motion import simulate

_ASKED = (
    ("regular", "1e-12", "heyoka", "at most 1.0"),
    ("eight links", "1e-12", "heyoka", "at most 0.6"),
)
_SLOWER = (("CVODES Adams", "at least 30"), ("SciPy DOP853", "at least 100"))


def energy_table() -> Table:
    """Energy and unit length over paper B's Fig. 2, T = 10 s, and energy over long times, by the Taylor flow."""
    work = next(work for work in problems() if work.words == "spatial")
    case = work.case
    system = build(case.scene())
    path = simulate(
        system, (np.array(case.q), np.array(case.v)), np.linspace(0, 10, 2001), method="taylor", tol=1e-16
    )
    rows = [
        ("paper B, Fig. 2, 10 s: energy, relative", f"{path.energy_drift / abs(path.energy[0]):.1e}", "1e-13"),
        ("paper B, Fig. 2, 10 s: unit length", f"{np.max(np.abs(path.length_error)):.1e}", "1e-14"),
    ]  # fmt: skip
    return Table("What the Taylor flow keeps", ("what", "kept to", "asked"), tuple(rows))


def table(measured: Mapping[str, Sequence[Row]]) -> Table:
    """Taylor against heyoka at one tolerance, and how many times slower CVODES and SciPy are at equal error."""
    cells = []
    for words, setting, peer, asked in _ASKED:
        rows = measured.get(words, ())
        mine = [
            row
            for row in rows
            if row.method == TAYLOR and row.setting == setting and row.seconds == row.seconds
        ]
        theirs = [
            row
            for row in rows
            if row.method.startswith(peer) and row.setting == setting and row.seconds == row.seconds
        ]
        if mine and theirs:
            best = min(theirs, key=lambda row: row.seconds)
            ratio = f"{mine[0].seconds / best.seconds:.2f}"
            words_of = f"time of {TAYLOR} over {best.method}, tolerance {setting}"
            cells.append((f"{words}: {words_of}", ratio, asked, f"{mine[0].error:.0e} / {best.error:.0e}"))
            if words == "eight links":
                quickest = min(theirs, key=lambda row: row.setup)
                for other in dict.fromkeys((best, quickest)):
                    what = f"{words}: description to running, over that of {other.method}"
                    cells.append((what, f"{mine[0].setup / other.setup:.2f}", "at most 0.5", ""))
    for words, rows in measured.items():
        for peer, asked in _SLOWER:
            cells += _slower(words, rows, peer, asked)
    heads = ("what", "ratio", "asked", "errors, ours / theirs")
    return Table("The ratios asked for", heads, tuple(cells))


def _slower(words: str, rows: Sequence[Row], peer: str, asked: str) -> list[tuple[str, ...]]:
    cells = []
    for row in rows:
        if not row.method.startswith(peer) or row.seconds != row.seconds:
            continue
        best = best_time(rows, (TAYLOR,), row.error)
        if best is not None:
            error = min(
                (r.error for r in rows if r.method == TAYLOR and r.seconds == best), default=float("nan")
            )
            what = f"{words}: time of {row.method} ({row.setting}) over {TAYLOR} at no larger error"
            cells.append((what, f"{row.seconds / best:.0f}", asked, f"{error:.0e} / {row.error:.0e}"))
    return cells
