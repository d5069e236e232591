"""``python -m benchmarks``: every table, written under benchmarks/results; ``make bench`` calls this.

``python -m benchmarks growth leaving_out`` makes those alone; each module also runs by itself, with options.
"""

from __future__ import annotations

import argparse
import sys
from importlib import import_module

MODULES = {
    "leaving_out": ["--write"],
    "growth": ["--write"],
    "generation": ["--write"],
    "fractional": ["--write"],
    "forward_dynamics": ["--peers", "heyoka", "casadi", "pinocchio", "mujoco", "--write"],
}


def main() -> int:
    p = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    p.add_argument("tables", nargs="*", help=f"any of {', '.join(MODULES)}; all by default")
    names = p.parse_args().tables or list(MODULES)
    unknown = [name for name in names if name not in MODULES]
    if unknown:
        p.error(f"no table {unknown[0]}; there are {', '.join(MODULES)}")
    for name in names:
        print(f"== {name}", flush=True)
        import_module(f"benchmarks.{name}").main(MODULES[name])
    return 0


if __name__ == "__main__":
    sys.exit(main())
