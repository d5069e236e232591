"""The chaos horizon of a motion: when one round-off has grown to an error that is no answer any more."""

from __future__ import annotations

import math

from benchmarks.stability.cases.case import Case
from benchmarks.stability.references import Reference
from benchmarks.stability.verdict import LIMIT

TENFOLD = 10.0
FAR = 1e3
"""Spans of the motion beyond which the horizon is not given: growth is not known so far ahead."""


def horizon(case: Case, known: Reference) -> float:
    """Seconds; infinity where round-off does not grow tenfold between the last two rows, or the horizon is far off.

    kappa(t) is carried on exponentially from the last two rows (from 1 at the start where there is one row).
    """
    times, kappas = (0.0, *map(abs, case.times)), (1.0, *(max(1.0, k) for k in known.kappa))
    if len(times) < 2 or len(times) != len(kappas):
        return math.inf
    growth = kappas[-1] / kappas[-2]
    if growth < TENFOLD:
        return math.inf
    rate = math.log(growth) / (times[-1] - times[-2])
    found = times[-1] + math.log(LIMIT / (case.round_off * kappas[-1])) / rate
    return max(0.0, found) if found < FAR * times[-1] else math.inf


def words(case: Case, known: Reference) -> str:
    """As the table gives it."""
    if case.kind != "motion":
        return "-"
    found = horizon(case, known)
    return "far" if math.isinf(found) else f"{found:.2g}"
