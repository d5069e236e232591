"""``python -m benchmarks.horizon [MOTION ...]``: see `run`."""

from __future__ import annotations

import sys

from benchmarks.horizon.cases import CASES
from benchmarks.horizon.judge import PEERS, RUNS, runs
from benchmarks.horizon.run import by_way, one_by_one, tables
from benchmarks.plan import FULL


def main(names: list[str]) -> int:
    if not names:
        print("\n".join(table.markdown() for table in tables(FULL)))
        return 0
    found = list(runs(tuple(case for case in CASES if case.name in names), (*RUNS, *PEERS)))
    print("\n".join(table.markdown() for table in (by_way(found), one_by_one(found))))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
