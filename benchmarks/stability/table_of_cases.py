"""Every case of the stability table, in its order, and the motions of the work-precision tables."""

from __future__ import annotations

from benchmarks.stability import dynamics_cases, motion_cases, shared_cases
from benchmarks.stability.case import Case


def all_cases() -> list[Case]:
    """The seventeen committed ones, then ours."""
    return [*shared_cases.cases(), *dynamics_cases.cases(), *motion_cases.cases()]


def work_cases() -> list[Case]:
    """The motions that `make report` times; their references lie in the same file."""
    from benchmarks.work_precision.problems import cases

    return cases()
