"""``python -m benchmarks``: every table, written under benchmarks/results; ``make bench`` calls this.

``python -m benchmarks growth leaving_out`` makes those alone; each module also runs by itself, with options.
"""

from __future__ import annotations

import argparse
import sys
from importlib import import_module

APART = {"stability": ["--write"], "work_precision": ["--write"]}
"""Made by ``make stability`` and ``make report``, or by name; not part of ``make bench``."""

MODULES = {
    "leaving_out": ["--write"],
    "growth": ["--write"],
    "generation": ["--write"],
    "fractional": ["--write"],
    "papers": ["--write"],
    "batch": ["--rounds", "200", "--write"],
    "forward_dynamics": ["--peers", "heyoka", "casadi", "pinocchio", "mujoco", "--write"],
}


def main() -> int:
    p = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    p.add_argument(
        "tables", nargs="*", help=f"any of {', '.join([*MODULES, *APART])}; by default {', '.join(MODULES)}"
    )
    names = p.parse_args().tables or list(MODULES)
    every = MODULES | APART
    unknown = [name for name in names if name not in every]
    if unknown:
        p.error(f"no table {unknown[0]}; there are {', '.join(every)}")
    for name in names:
        print(f"== {name}", flush=True)
        import_module(f"benchmarks.{name}").main(every[name])
    return 0


if __name__ == "__main__":
    sys.exit(main())
