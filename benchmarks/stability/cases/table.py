"""Every case of the stability table, in its order, and the motions of the work-precision tables."""

from __future__ import annotations

from benchmarks.stability.cases import dynamics, motions, shared
from benchmarks.stability.cases.case import Case


def all_cases() -> list[Case]:
    """The seventeen committed ones, then ours."""
    return [*shared.cases(), *dynamics.cases(), *motions.cases()]


def work_cases() -> list[Case]:
    """The motions that `make report` times; their references lie in the same file."""
    from benchmarks.work_precision.problems import cases

    return cases()
