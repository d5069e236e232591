"""Both papers' runs: computed torque, the chain left alone, gains, and paper B's Fig. 2 in as many digits as asked for."""

from __future__ import annotations

from collections.abc import Sequence


def main(arguments: Sequence[str] | None = None) -> None:
    """The command; see `benchmarks.papers.run`."""
    from benchmarks.papers.run import main as run

    run(arguments)
