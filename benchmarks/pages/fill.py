"""Puts measured tables into docs/performance.md: what stands between two marks comes from benchmarks/results.

    python -m benchmarks.pages.fill           # write
    python -m benchmarks.pages.fill --check   # is the page as the results are?

A mark is ``<!-- from FILE: HEADING -->`` and ``<!-- end -->``; between them stands the table of ``benchmarks/results/FILE.md`` below
``## HEADING``, with the day it was measured. A file that is not there leaves a line that says how to make it.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Sequence
from pathlib import Path

from benchmarks.table import RESULTS

PAGE = Path(__file__).resolve().parents[2] / "docs" / "performance.md"
_BLOCK = re.compile(r"(<!-- from (\w+): (.+?) -->\n)(.*?)(<!-- end -->)", re.DOTALL)


def filled(text: str, results: Path = RESULTS) -> str:
    """The page with every block as the results are now."""
    return _BLOCK.sub(lambda m: f"{m[1]}{block(m[2], m[3], results)}{m[5]}", text)


def block(name: str, heading: str, results: Path) -> str:
    """One table and when it was measured.

    Raises:
        ValueError: The file has no such heading.
    """
    path = results / f"{name}.md"
    if not path.exists():
        return f"*Not measured yet: `make bench-{name.replace('_', '-')}`.*\n"
    text = path.read_text()
    _, mark, after = text.partition(f"\n## {heading}\n")
    if not mark:
        there = re.findall(r"^## (.+)$", text, re.MULTILINE)
        raise ValueError(f"{path.name} has no table {heading!r}; it has {', '.join(there)}")
    lines = [line for line in after.partition("\n## ")[0].splitlines() if line.startswith("|")]
    # A table's links lead to its neighbours; on this page those stand elsewhere.
    lines = [re.sub(r"\]\((\w+\.md)\)", r"](../benchmarks/results/\1)", line) for line in lines]
    found = re.search(r"Measured (\S+)", text)
    day = f"Measured {found[1]}" if found else "Measured"
    return "\n".join([*lines, "", f"{day}; the whole file: [{name}.md](../benchmarks/results/{name}.md)."]) + "\n"


def main(arguments: Sequence[str] | None = None) -> int:
    given = list(sys.argv[1:] if arguments is None else arguments)
    before = PAGE.read_text()
    after = filled(before)
    if "--check" in given:
        if before != after:
            print("docs/performance.md is not as benchmarks/results are: python -m benchmarks.pages.fill", file=sys.stderr)
        return int(before != after)
    PAGE.write_text(after)
    print(PAGE)
    return 0


if __name__ == "__main__":
    sys.exit(main())
