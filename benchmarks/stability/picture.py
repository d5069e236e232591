"""The picture of a table of verdicts that was measured before: `python -m benchmarks.stability.picture` draws docs/img/stability.png anew."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Final

from benchmarks.stability.cases.table import all_cases
from benchmarks.stability.report import ORDER, label
from phichain.report.measured.verdicts import draw_verdicts

ROOT: Final = Path(__file__).resolve().parents[2]
TABLE: Final = ROOT / "benchmarks" / "results" / "stability.md"


def verdicts(text: str) -> dict[tuple[str, str], str]:
    """(case's id, method) -> verdict, from the lines of a written table; methods of ours first.

    Raises:
        ValueError: A verdict is none.
    """
    found: dict[tuple[str, str], str] = {}
    ours: dict[tuple[str, str], str] = {}
    case = ""
    for line in text.splitlines():
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        named = re.match(r"\*\*(\w\d\d)\*\*", cells[0])
        case = named[1] if named else case if not cells[0] else ""
        if not case or len(cells) < 7:
            continue
        verdict = cells[-1].partition(":")[0]
        if verdict not in ORDER:
            raise ValueError(f"{case}, {cells[1]}: {verdict!r} is no verdict")
        is_ours = cells[1].startswith("**")
        (ours if is_ours else found)[case, cells[1].strip("*")] = verdict
    return ours | found


def draw(table: Path, out: Path) -> Path:
    """Draw the picture of a written table."""
    cells = verdicts(table.read_text(encoding="utf-8"))
    labels = {case.id: label(case) for case in all_cases()}
    methods = list(dict.fromkeys(method for _, method in cells))
    cases = [labels[case] for case in labels if any(case == known for known, _ in cells)]
    return draw_verdicts(out, cases, methods, {(labels[case], method): verdict for (case, method), verdict in cells.items()}, ORDER)


if __name__ == "__main__":
    print(draw(TABLE, ROOT / "docs" / "img" / "stability.png"))
