"""Everything a newcomer meets, measured: results/front_door.md.

Examples::

    python -m benchmarks.front_door --tiny            # does it run? Nothing is written
    python -m benchmarks.front_door --write           # half an hour and more, most of it `make test` in a clone
    python -m benchmarks.front_door --write --without-tests
"""

from __future__ import annotations

import argparse
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Final

from benchmarks.campaign import clock
from benchmarks.front_door import documented, exchanged, installed, studied
from benchmarks.plan import FULL, TINY, Plan
from benchmarks.table import Table, write

HEADING: Final = "The front door: what a newcomer meets"
COMMAND: Final = "python -m benchmarks front_door"


def tables(plan: Plan, tests: bool, clone: bool = True, told: Callable[[str], None] = print) -> list[Table]:
    """All tables, each in its turn.

    Args:
        plan: How much is measured.
        tests: Whether `make test` is run in the clone.
        clone: Whether there is one.
        told: Is given each table as it is done.
    """
    found: list[Table] = []

    def done(table: Table) -> None:
        found.append(table)
        told(table.markdown())

    with tempfile.TemporaryDirectory(prefix="phichain-front-") as folder:
        scratch = Path(folder)
        made = installed.installed(scratch)
        done(installed.first_result(made, scratch))
        done(installed.commands(made, scratch, plan))
        done(studied.table(scratch, plan))
        done(exchanged.table(scratch))
        done(documented.table(scratch, plan))
        if clone and not plan.tiny:
            done(installed.two_commands(scratch, tests))
    return found


def main(arguments: Sequence[str] | None = None) -> int:
    """The command."""
    p = argparse.ArgumentParser(prog="python -m benchmarks.front_door", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--tiny", action="store_true", help="the smallest counts, no site, no clone")
    p.add_argument("--without-tests", action="store_true", help="leave `make test` in the clone out")
    p.add_argument("--without-clone", action="store_true", help="leave the clone out")
    p.add_argument("--write", action="store_true", help="write benchmarks/results/front_door.md")
    options = p.parse_args(arguments)
    begin = clock()
    found = tables(TINY if options.tiny else FULL, not options.without_tests, not options.without_clone)
    if options.write and not options.tiny:
        left = "".join(f" --{word}" for word in ("without-tests", "without-clone") if getattr(options, word.replace("-", "_")))
        command = COMMAND if not left else f"python -m benchmarks.front_door --write{left}"
        print(write("front_door", HEADING, found, command, seconds=clock() - begin))
    return 0
