"""``make report``: error against run time for each kind of work, beside the peers, in one run.

python -m benchmarks.work_precision --quick
python -m benchmarks.work_precision --work integration families
python -m benchmarks.work_precision --write
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path

from benchmarks.pages.html import Figure, write_page
from benchmarks.table import Table, write
from benchmarks.work_precision import sections

WORK: dict[str, tuple[str, Callable[[bool, Path], sections.Section]]] = {
    "integration": ("Integration", sections.integration),
    "forward_dynamics": ("Forward dynamics", sections.forward_dynamics),
    "families": ("Single-harmonic families", sections.families),
    "fractional": ("Fractional operators", sections.fractional),
}


def parser() -> argparse.ArgumentParser:
    """The command line."""
    p = argparse.ArgumentParser(
        prog="python -m benchmarks.work_precision",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    p.add_argument("--work", nargs="+", choices=tuple(WORK), default=list(WORK))
    p.add_argument("--quick", action="store_true", help="fewer methods, tolerances and rounds")
    p.add_argument("--write", action="store_true", help="write benchmarks/results/work_precision_*.md")
    p.add_argument(
        "--out", type=Path, default=Path("generated/report"), help="folder of the page and its figures"
    )
    return p


def main(arguments: Sequence[str] | None = None) -> int:
    given = list(sys.argv[1:] if arguments is None else arguments)
    options = parser().parse_args(given)
    options.out.mkdir(parents=True, exist_ok=True)
    command = " ".join(["python -m benchmarks.work_precision", *given])
    figures: list[Figure] = []
    tables: list[Table] = []
    for name in options.work:
        title, make = WORK[name]
        begin = time.perf_counter()
        print(f"== {title}", flush=True)
        section = make(options.quick, options.out)
        for table in section.tables:
            print(table.markdown(), flush=True)
        figures += section.figures
        tables += section.tables
        if options.write:
            print(
                write(f"work_precision_{name}", f"{title}: error against run time", section.tables, command)
            )
        print(f"   {time.perf_counter() - begin:.0f} s", flush=True)
    print(
        write_page(
            options.out / "work_precision.html",
            "Error against run time",
            f"Made by {command}.",
            figures,
            tables,
        )
    )
    return 0
