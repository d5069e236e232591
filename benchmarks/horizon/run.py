"""Estimated errors of chaotic runs of 60 s over those they have, method by method, and what an estimate costs.

    python -m benchmarks horizon            # everything, written to benchmarks/results/horizon.md
    python -m benchmarks.horizon            # the same, printed
    python -m benchmarks.horizon triple     # the runs of some motions alone
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from functools import partial
from itertools import groupby

import numpy as np

from benchmarks.horizon.cases import CASES, TIMES, Case
from benchmarks.horizon.judge import LOOSE, PEERS, RUNS, Found, runs
from benchmarks.plan import Plan
from benchmarks.table import Table

HEADING = "How far simulations see: estimated over true errors"
BOUNDS = (0.1, 100.0)
"""Of estimated over true errors."""
MOST = 1e-2
"""The largest error that may stay unmarked, of the motion."""
FORTY = (("taylor", None), ("taylor", LOOSE), ("DOP853", None), ("DOP853", LOOSE))
"""The ways of the forty runs that `tests/motion/test_horizon.py` holds to these bounds; the others are shown beside them."""
_COLUMNS = ("tolerance", "runs", "estimated over true: least, middle, largest", "largest error before it is marked", "outside the bounds")


def tolerance(tol: float | None) -> str:
    return "default" if tol is None else f"{tol:.0e}"


def is_within(found: Found) -> bool:
    """Whether a run keeps the bounds."""
    ratio = found.ratio
    return bool(np.all((ratio >= BOUNDS[0]) & (ratio <= BOUNDS[1]))) and found.unmarked < MOST


def _spread(ratios: np.ndarray) -> str:
    return f"{np.min(ratios):.2g}, {np.median(ratios):.2g}, {np.max(ratios):.2g}" if ratios.size else "-"


def by_way(found: Sequence[Found]) -> Table:
    """All motions of a method and tolerance in one row."""
    kinds, rows = [*RUNS, *PEERS], []
    ordered = sorted(found, key=lambda one: kinds.index((one.method, one.tol)))
    for (method, tol), group in groupby(ordered, key=lambda one: (one.method, one.tol)):
        those = list(group)
        ratios = np.concatenate([one.ratio for one in those])
        name = f"**{method}**" if (method, tol) in FORTY else method
        outside = ", ".join(one.case for one in those if not is_within(one)) or "none"
        most = max(one.unmarked for one in those)
        rows.append((name, tolerance(tol), str(len(those)), _spread(ratios), f"{most:.1e}", outside))
    bounds = f"Bounds: {BOUNDS[0]:g} to {BOUNDS[1]:g} times the true error at every output, and no error above {MOST:g} of the motion before `holds_until`."
    notes = (
        f"{bounds} Ratios count where the true error is above 1e-15 and until both say that the run is lost.",
        "References: binary128 (`benchmarks/horizon/make_references.py`). In bold: the forty runs that `tests/motion/test_horizon.py` holds to the bounds.",
    )
    return Table("Ten motions of two and three links, 60 s", ("method", *_COLUMNS), tuple(rows), notes)


def one_by_one(found: Sequence[Found]) -> Table:
    """A row for each run."""
    columns = ("run", "method", "tolerance", "estimated over true: least, middle, largest", "largest error before it is marked", "holds until, s")
    rows = [
        (one.case, one.method, tolerance(one.tol), _spread(one.ratio), f"{one.unmarked:.1e}", f"{one.holds_until:g}") for one in found
    ]
    return Table("Every run", columns, tuple(rows))


def cost(cases: Sequence[Case], rounds: int) -> Table:
    """A run with its verdict read over one without an estimate, in turns; processor time."""
    rows = []
    for case in cases:
        for times, what in (((0.0, 10.0), "10 s, its own steps"), (TIMES, "60 s, 31 times")):
            rows.append((case.name, what, *_ratios(case, np.array(times), rounds)))
    heads = ("run", "over", *(f"{method}, {tolerance(tol)}" for method, tol in COSTED))
    note = "The run with its status read over the same with `error_estimate=False`: medians of rounds in turns, quartiles, time of the latter."
    return Table("What an estimate costs", heads, tuple(rows), (note,))


COSTED: tuple[tuple[str, float | None], ...] = (("taylor", None), ("taylor", 1e-9), ("taylor", LOOSE))


def _ratios(case: Case, times: np.ndarray, rounds: int) -> list[str]:
    from phichain import build
    from phichain.motion import simulate

    system = build(case.scene())

    def seconds(call: Callable[[], object], repeats: int) -> float:
        begin = time.process_time()
        for _ in range(repeats):
            call()
        return (time.process_time() - begin) / repeats

    def judged(method: str, tol: float | None, is_judged: bool) -> str:
        return simulate(system, case.x0, times, method, tol, error_estimate=is_judged).status

    cells = []
    for method, tol in COSTED:
        with_it, without = partial(judged, method, tol, True), partial(judged, method, tol, False)
        repeats = max(1, int(0.01 / max(seconds(without, 1), 1e-5)))
        pairs = [(seconds(with_it, repeats), seconds(without, repeats)) for _ in range(rounds)]
        ratio = np.quantile([a / b for a, b in pairs], (0.25, 0.5, 0.75))
        own = np.median([b for _, b in pairs]) * 1e3
        cells.append(f"{ratio[1]:.2f} [{ratio[0]:.2f}, {ratio[2]:.2f}] of {own:.2g} ms")
    return cells


def tables(plan: Plan) -> list[Table]:
    """All methods, what an estimate costs, every run."""
    cases, ways = plan.few(CASES), plan.few([*RUNS, *PEERS], 3)
    found = list(runs(tuple(cases), tuple(ways)))
    return [by_way(found), cost(cases, 3 if plan.tiny else 9), one_by_one(found)]
