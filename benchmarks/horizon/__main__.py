"""The estimated errors of chaotic runs of 60 s over those they have, method by method, as a table.

    python -m benchmarks.horizon [NAME ...]
"""

from __future__ import annotations

import sys

import numpy as np

from benchmarks.horizon.cases import CASES
from benchmarks.horizon.judge import PEERS, RUNS, runs


def main(names: list[str]) -> int:
    cases = tuple(case for case in CASES if not names or case.name in names)
    print("| run | method | tolerance | estimated over true: least, middle, largest | largest error before it is marked | holds until, s |")
    print("| --- | --- | ---: | ---: | ---: | ---: |")
    for found in runs(cases, (*RUNS, *PEERS)):
        ratio = found.ratio
        middle = f"{np.min(ratio):.2g}, {np.median(ratio):.2g}, {np.max(ratio):.2g}" if ratio.size else "-"
        tol = "default" if found.tol is None else f"{found.tol:.0e}"
        print(f"| {found.case} | {found.method} | {tol} | {middle} | {found.unmarked:.1e} | {found.holds_until:g} |", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
