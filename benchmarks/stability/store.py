"""Results of earlier runs, so that a long table can be made, or mended, in pieces."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from benchmarks.stability.cases.case import Case
from benchmarks.stability.horizon import words
from benchmarks.stability.references import Reference
from benchmarks.stability.report import Result
from benchmarks.stability.verdict import Answer, judge


def keep(path: Path, results: Sequence[Result], source: str) -> None:
    """Write results, over those of the same case and method that are there; `source` is the digest of the code."""
    stored = _read(path)
    for result in results:
        entry = {"own": result.own, "answer": asdict(result.answer), "source": source}
        stored.setdefault(result.case.id, {})[result.method] = entry
    path.parent.mkdir(parents=True, exist_ok=True)
    unfinished = path.with_suffix(".part")
    unfinished.write_text(json.dumps(stored, indent=1) + "\n")
    unfinished.replace(path)


def done(path: Path, source: str) -> set[tuple[str, str]]:
    """(case, method) of every stored result of that very code."""
    return {
        (case, method)
        for case, methods in _read(path).items()
        for method, entry in methods.items()
        if entry.get("source") == source
    }


def kept(
    path: Path, cases: Sequence[Case], known: dict[str, Reference], order: Sequence[str]
) -> list[Result]:
    """Every stored result of these cases, judged anew, methods in the given order."""
    stored, found = _read(path), []
    for case in cases:
        rows = [
            Result(
                case, method, entry["own"], answer, judge(answer, known[case.id].kappa, case.round_off),
                words(case, known[case.id]),
            )
            for method, entry in stored.get(case.id, {}).items()
            for answer in [Answer(**{**entry["answer"], "errors": tuple(entry["answer"]["errors"])})]
        ]  # fmt: skip
        found += sorted(rows, key=lambda row: order.index(row.method) if row.method in order else -1)
    return found


def _read(path: Path) -> dict[str, dict[str, Any]]:
    content: dict[str, dict[str, Any]] = json.loads(path.read_text()) if path.exists() else {}
    return content
