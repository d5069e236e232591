"""The table of the front door: commands are timed and judged as a user meets them, and what its rows count is counted."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import pytest

from benchmarks.front_door import documented, exchanged, installed
from benchmarks.front_door.processes import clean, megabytes, often, run
from benchmarks.harness import BenchmarkError
from benchmarks.plan import TINY
from docs.site import reference


def test_a_command_is_timed_without_the_checkout(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PYTHONPATH", "somewhere")
    done = run([sys.executable, "-c", "import os; print(sorted(os.environ))"], tmp_path, clean(PHICHAIN_CACHE="there"))
    assert "PYTHONPATH" not in done.said and "PHICHAIN_CACHE" in done.said and 0 < done.user and 0 < done.wall
    assert often([sys.executable, "-c", "pass"], tmp_path, os.environ, 2) > 0
    with pytest.raises(BenchmarkError, match="no such luck"):
        run([sys.executable, "-c", "raise SystemExit('no such luck')"], tmp_path, os.environ)


def test_what_a_folder_takes_is_all_of_its_files(tmp_path: Path) -> None:
    (tmp_path / "a").mkdir()
    (tmp_path / "a" / "b").write_bytes(b"x" * 250_000)
    (tmp_path / "link").symlink_to(tmp_path / "a" / "b")
    assert megabytes(tmp_path) == pytest.approx(0.25, abs=1e-3)


@pytest.mark.long
def test_an_fmu_moves_as_simulate_does(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(exchanged, "SCENES", exchanged.SCENES[1:2])
    apart, problems = exchanged.table(tmp_path).rows
    assert float(apart[1]) < 1e-10 and problems[1] == "nothing"


def test_what_is_documented_is_counted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    rows = documented.table(tmp_path, TINY).rows
    assert all(row[0].endswith(f"of {row[1]}") for row in rows) and len(rows) == 4
    less = {**reference.pages(), "scene.md": ""}
    monkeypatch.setattr(reference, "pages", lambda: less)
    assert documented.table(tmp_path, TINY).rows[0][1] == "0"


def test_a_make_that_fails_is_told_in_its_row(tmp_path: Path) -> None:
    name, said, _ = installed._timed("it", [sys.executable, "-c", "raise SystemExit('broken')"], tmp_path, os.environ)
    assert name == "it" and said.startswith("not done: ") and said.endswith("broken")
    closing = installed._timed("it", [sys.executable, "-c", "print('=== 7 passed in 3 s ===')"], tmp_path, os.environ, r"=+ (.*passed.*) =+")
    assert closing[1].endswith("; 7 passed in 3 s")
