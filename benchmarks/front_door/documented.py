"""The documentation: what its strict build counts, and whether keys and names are all in it."""

from __future__ import annotations

import re
import sys
from pathlib import Path

import phichain
from benchmarks.front_door.processes import clean, run
from benchmarks.harness import BenchmarkError
from benchmarks.plan import Plan
from benchmarks.table import Table
from docs.site import reference, theory
from phichain.contract.functions import FUNCTIONS
from phichain.scene.keys import TABLES

ROOT = Path(__file__).resolve().parents[2]


def table(scratch: Path, plan: Plan) -> Table:
    """Counts of the build, and of what the references hold."""
    pages = reference.pages()
    keys = [key for table in TABLES.values() for key in table]
    named = set(re.findall(r"auto\w+:: phichain\.(\w+)\n", pages["api.md"]))
    parts = theory.parts((ROOT / theory.PAGE).read_text())
    rows = [
        _counted("scene keys in the reference", keys, [key for key in keys if f"| `{key}` |" in pages["scene.md"]]),
        _counted("functions of the contract in theirs", FUNCTIONS, [name for name in FUNCTIONS if f"## `{name}`" in pages["functions.md"]]),
        _counted("public names of phichain in theirs", phichain.__all__, [name for name in phichain.__all__ if name in named]),
        (f"parts of the theory with a figure and a table of symbols, of {len(parts)}", str(sum(bool(part.figures and part.symbols) for part in parts)), "every"),
    ]
    if not plan.tiny:
        rows = [*_built(scratch), *rows]
    return Table("Documentation", ("what", "measured", "reach"), tuple(rows), ("`make docs` in an empty folder; its summary says what it ran.",))


def _counted(name: str, wanted: object, found: list[str]) -> tuple[str, str, str]:
    count = len(list(wanted))  # type: ignore[call-overload]
    return f"{name}, of {count}", str(len(found)), "every"


def _built(scratch: Path) -> list[tuple[str, str, str]]:
    environment = clean(PYTHONPATH=f"{ROOT / 'codegen'}:{ROOT}", PHICHAIN_CACHE=str(scratch / "cache"))
    try:
        done = run([sys.executable, "-m", "docs.site", "--out", scratch / "site"], ROOT, environment)
    except BenchmarkError as failure:
        return [("`make docs`", f"failed: {failure}", "0 warnings")]
    told = dict(re.findall(r"^  ([^:\n]+): +(.+)$", done.said, re.MULTILINE))
    rows = [("`make docs`, strict", f"{done.wall:.0f} s, 0 warnings", "0 warnings")]
    reaches = {"links": "0 dead", "code blocks": "every one"}
    return rows + [(name, value, reaches.get(name, "-")) for name, value in told.items()]
