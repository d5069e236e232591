"""How much a table measures: in full, or tiny, as the tests run it; and the command line that all tables share."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeVar

from benchmarks.table import Table, write

Size = TypeVar("Size")


@dataclass(frozen=True)
class Plan:
    """Counts of a run.

    Attributes:
        rounds: Rounds of a race.
        budget: Seconds that a race of Python callables may take, about.
        states: Random states of the functions timed from C.
        tiny: Take the smallest of every list of sizes and settings: a table that runs, and says nothing.
    """

    rounds: int = 41
    budget: float = 2.5
    states: int = 4096
    tiny: bool = False

    def few(self, values: Sequence[Size], least: int = 1) -> list[Size]:
        """All of them, or the first `least` in a tiny run."""
        return list(values[:least]) if self.tiny else list(values)


TINY = Plan(rounds=3, budget=0.05, states=16, tiny=True)
FULL = Plan()

Tables = Callable[[Plan], list[Table]]


def command(
    name: str, module: str, heading: str, tables: Tables, arguments: Sequence[str] | None, about: str | None
) -> int:
    """``python -m MODULE [--tiny] [--rounds N] [--write]``: print one file of tables, and write it if asked.

    Args:
        name: Of the file under benchmarks/results.
        module: What stands behind ``python -m``.
        heading: Of the file.
        tables: Makes them.
        arguments: Of the command line; sys.argv by default.
        about: The help.
    """
    p = argparse.ArgumentParser(
        prog=f"python -m {module}", description=about, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    p.add_argument("--tiny", action="store_true", help="the smallest sizes and counts: does it run at all?")
    p.add_argument("--rounds", type=int, help=f"rounds of every race, {FULL.rounds} by default")
    p.add_argument("--write", action="store_true", help=f"write benchmarks/results/{name}.md")
    options = p.parse_args(arguments)
    plan = TINY if options.tiny else FULL
    if options.rounds:
        plan = Plan(options.rounds, plan.budget, plan.states, plan.tiny)
    found = tables(plan)
    print("\n".join(table.markdown() for table in found))
    if options.write:
        print(write(name, heading, found, f"python -m {module} --write"))
    return 0
