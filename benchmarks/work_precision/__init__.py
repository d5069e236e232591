"""Error against run time, for each kind of work: tables, plots, one page."""

from __future__ import annotations

from collections.abc import Sequence


def main(arguments: Sequence[str] | None = None) -> int:
    """The command; see `benchmarks.work_precision.run`."""
    from benchmarks.work_precision.run import main as run

    return run(arguments)
