"""``python -m benchmarks``: every table, written under benchmarks/results; ``make bench`` calls this.

    python -m benchmarks                       # all; goes on where an interrupted run of the same code stopped
    python -m benchmarks --fresh               # all, from the start
    python -m benchmarks flows jacobians       # these alone (make bench-flows is the same for one)
    python -m benchmarks --tiny                # does everything run? The smallest counts, nothing is written

Each table's module runs by itself, too: `python -m benchmarks.flows.taylor --help`.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from importlib import import_module
from typing import Final

from benchmarks import campaign
from benchmarks.plan import FULL, TINY
from benchmarks.table import write

APART: Final = {"stability": ["--write"], "work_precision": ["--write"], "front_door": ["--write"]}
"""Made by ``make stability``, ``make report`` and ``make bench-front-door``, or by name; not part of ``make bench``."""

MODULES: Final = {
    "forward_dynamics": "benchmarks.dynamics.forward",
    "jacobians": "benchmarks.dynamics.jacobians",
    "batch": "benchmarks.dynamics.batch",
    "flows": "benchmarks.flows.taylor",
    "columns": "benchmarks.flows.columns",
    "equal_error": "benchmarks.flows.equal_error",
    "single_precision": "benchmarks.flows.single_precision",
    "python_calls": "benchmarks.calls.python",
    "harmonics": "benchmarks.orbits.harmonics",
    "regulators": "benchmarks.control.all_gains",
    "generation": "benchmarks.building.generation",
    "growth": "benchmarks.building.growth",
    "leaving_out": "benchmarks.building.leaving_out",
    "fractional": "benchmarks.fractional.run",
    "families": "benchmarks.orbits.families",
    "papers": "benchmarks.papers.run",
    "horizon": "benchmarks.horizon.run",
    "fit": "benchmarks.identification.coverage",
}
"""Table -> the module with its HEADING and its ``tables(plan)``."""


def main(arguments: Sequence[str] | None = None) -> int:
    p = argparse.ArgumentParser(
        prog="python -m benchmarks", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    every = [*MODULES, *APART]
    p.add_argument("tables", nargs="*", help=f"any of {', '.join(every)}; by default {', '.join(MODULES)}")
    p.add_argument("--fresh", action="store_true", help="do not go on with an interrupted run")
    p.add_argument("--tiny", action="store_true", help="the smallest sizes and counts; nothing is written")
    options = p.parse_args(arguments)
    unknown = [name for name in options.tables if name not in every]
    if unknown:
        p.error(f"no table {unknown[0]}; there are {', '.join(every)}")
    if options.tiny:
        for name in options.tables or MODULES:
            print(f"== {name}", flush=True)
            import_module(MODULES[name]).tables(TINY)
        return 0
    for name in options.tables:
        if name in APART:
            import_module(f"benchmarks.{name}").main(APART[name])
        else:
            make(name)
    if not options.tables:
        whole(options.fresh)
    return 0


def make(name: str) -> float:
    """Make and write one table; returns the seconds it took."""
    print(f"== {name}", flush=True)
    begin = campaign.clock()
    module = import_module(MODULES[name])
    found = module.tables(FULL)
    seconds = campaign.clock() - begin
    print(write(name, module.HEADING, found, f"python -m benchmarks {name}", seconds=seconds), f"{seconds:.0f} s", flush=True)
    return seconds


def whole(fresh: bool) -> None:
    """Every table that an interrupted run has not made already."""
    run = campaign.begun(fresh)
    for name in MODULES:
        if name in run.seconds:
            print(f"== {name}: done in {run.seconds[name]:.0f} s before", flush=True)
            continue
        run = campaign.kept(run, name, make(name))
    print(campaign.ended(run, MODULES))


if __name__ == "__main__":
    sys.exit(main())
