"""The machinery around the tables: processes with limits, rows and ratios, pages and pictures."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchmarks.pages.html import Figure, write_page
from benchmarks.stability.apart import TIME_LIMIT, run_apart
from benchmarks.stability.cases.table import all_cases
from benchmarks.stability.ours import Method, answer, methods
from benchmarks.stability.references import references
from benchmarks.stability.report import Result, markdown_tables
from benchmarks.stability.verdict import RIGHT, UNFINISHED, Answer, judge
from benchmarks.table import Table
from benchmarks.work_precision.rows import Candidate, Row, as_table, best_time, measure, ratio_cell
from phichain import build
from phichain.report.measured.verdicts import draw_verdicts
from phichain.report.measured.work_precision import Curve, draw_work_precision

PNG = b"\x89PNG\r\n\x1a\n"


def endless() -> None:
    while True:
        pass


def broken() -> None:
    raise ValueError("no such thing")


def test_work_apart_comes_back_or_is_stopped() -> None:
    work = [("sum", lambda: 1 + 1), ("endless", endless), ("broken", broken)]
    found = {done.key: done for done in run_apart(work, seconds=1, jobs=3)}
    assert found["sum"].result == 2
    assert found["endless"].failure == TIME_LIMIT
    assert "no such thing" in found["broken"].failure


def rows() -> list[Row]:
    table = [("a", 1e-3, 1.0), ("a", 1e-6, 2.0), ("b", 1e-4, 6.0), ("b", 1e-9, 9.0)]
    return [Row(method, "", method == "a", error, seconds, float("nan")) for method, error, seconds in table]


def test_ratios_are_taken_at_no_larger_error() -> None:
    found = rows()
    assert best_time(found, ("a",), 1e-4) == 2.0
    assert best_time(found, ("a",), 1e-7) is None
    assert ratio_cell(found[2], found, ("a",)) == "3"
    assert ratio_cell(found[3], found, ("a",)) == "4.5 (at its 1e-06)"
    cells = as_table("t", found, {"x a": ("a",)}, ("ms", 1e-3)).rows
    assert cells[0][:5] == ("**a**", "", "1.0e-03", "1000", "1")


def test_a_candidate_that_fails_becomes_a_row_that_says_so() -> None:
    def error(value: object) -> float:
        return 0.5

    good = Candidate("good", "", True, lambda: 1, error)
    bad = Candidate("bad", "", False, broken, error)
    found = measure([good, bad], rounds=3, patience=1.0)
    assert found[0].error == 0.5 and found[0].seconds >= 0
    assert found[1].note == "no such thing" and np.isnan(found[1].seconds)


@pytest.mark.parametrize("name", ["B14", "C03"])
def test_a_method_is_judged_on_a_case(name: str) -> None:
    case = next(case for case in all_cases() if case.id == name)
    known = references()[name]
    lean = {**case.chain, "want": ["forward_dynamics", "energy"]}
    from phichain.scene import Scene

    system = build(Scene("lean", **lean))
    found = answer(case, system, Method("DOP853", "DOP853", 1e-13), known)
    assert found.status == "ok"
    assert judge(found, known.kappa, case.round_off).verdict == RIGHT


def test_every_method_of_a_quick_run_is_one_of_the_full() -> None:
    assert set(methods(True)) <= set(methods(False))
    assert {"auto", "DOP853", "cvodes"} <= {method.name for method in methods(True)}


def test_the_table_says_what_was_said() -> None:
    case = all_cases()[0]
    answer_ = Answer("unfinished", said="step budget: 10 | steps")
    result = Result(case, "taylor", True, answer_, judge(answer_, [1.0], case.round_off))
    text = "\n".join(table.markdown() for table in markdown_tables([result], 3.0))
    assert f"{UNFINISHED}: step budget: 10 / steps" in text
    assert f"**{case.id}**" in text


def test_pages_hold_their_pictures(tmp_path: Path) -> None:
    curves = [
        Curve("taylor", [1e-3, 2e-3], [1e-9, 0.0], True),
        Curve("heyoka", [1e-3, np.nan], [1e-8, 1e-9], False),
    ]
    picture = draw_work_precision(tmp_path / "curves.png", "N = 2", curves, floor=1e-15)
    verdicts = draw_verdicts(
        tmp_path / "verdicts.png", ["A01"], ["taylor"], {("A01", "taylor"): "right"}, ["right"]
    )
    assert picture.read_bytes().startswith(PNG) and verdicts.read_bytes().startswith(PNG)
    table = Table("A <table>", ("case", "verdict"), (("**A01**", "right"),), ("a note",))
    page = write_page(
        tmp_path / "page.html", "Title", "lead", [Figure(picture, "curves")], [table]
    ).read_text()
    assert "data:image/png;base64," in page and "<strong>A01</strong>" in page and "A &lt;table&gt;" in page
    assert 'src="curves.png"' not in page
