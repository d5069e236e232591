"""What a newcomer meets, measured: the first result, the commands, studies, exchange, documentation."""

from __future__ import annotations

from collections.abc import Sequence


def main(arguments: Sequence[str] | None = None) -> int:
    """The command; see `benchmarks.front_door.run`."""
    from benchmarks.front_door.run import main as run

    return run(arguments)
