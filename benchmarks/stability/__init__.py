"""Stiff and extreme cases as a table: case x method, reached and attainable error, steps, verdict."""

from __future__ import annotations

from collections.abc import Sequence


def main(arguments: Sequence[str] | None = None) -> int:
    """The command; see `benchmarks.stability.run`."""
    from benchmarks.stability.run import main as run

    return run(arguments)
