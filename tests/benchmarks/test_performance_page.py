"""docs/performance.md shows the committed results and nothing typed."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from benchmarks.__main__ import MODULES
from benchmarks.pages import fill
from benchmarks.table import RESULTS, Table, write


def test_the_page_is_as_the_results_are() -> None:
    assert fill.main(["--check"]) == 0


def test_every_block_names_a_table_that_bench_makes() -> None:
    named = re.findall(r"<!-- from (\w+): ", fill.PAGE.read_text())
    assert set(named) <= {*MODULES, "durations"} and len(named) > 12
    assert fill.PAGE.read_text().count("<!-- end -->") == len(named)


def test_a_block_is_the_table_below_its_heading(tmp_path: Path) -> None:
    tables = [Table("First", ("a", "b"), (("1", "2"),), ("a note",)), Table("Second", ("c", "d"), (("3", "4"),))]
    write("t", "x", tables, "make bench", tmp_path)
    page = "before\n<!-- from t: First -->\nold | figures\n<!-- end -->\nafter\n<!-- from u_v: Any -->\n<!-- end -->\n"
    text = fill.filled(page, tmp_path)
    assert "| 1 | 2 |" in text and "| 3 | 4 |" not in text and "old" not in text and "a note" not in text
    assert text.startswith("before\n") and "\nafter\n" in text and "make bench-u-v" in text
    assert re.search(r"Measured \d{4}-\d\d-\d\d;", text)
    assert fill.filled(text, tmp_path) == text


def test_a_heading_that_is_not_there_is_named(tmp_path: Path) -> None:
    write("t", "x", [Table("First", ("a", "b"), (("1", "2"),))], "make bench", tmp_path)
    with pytest.raises(ValueError, match="has no table 'Third'; it has First"):
        fill.filled("<!-- from t: Third -->\n<!-- end -->\n", tmp_path)


def test_results_that_are_there_are_named_in_the_readme() -> None:
    readme = (RESULTS.with_name("README.md")).read_text()
    assert RESULTS.is_dir()
    for name in MODULES:
        assert f"make bench-{name.replace('_', '-')}" in readme, name
