"""Fractional operators beside their peers: differintegrals, powers of matrices, measured orders."""

from __future__ import annotations

from collections.abc import Sequence


def main(arguments: Sequence[str] | None = None) -> None:
    """The command; see `benchmarks.fractional.run`."""
    from benchmarks.fractional.run import main as run

    run(arguments)
