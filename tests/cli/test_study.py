"""`phichain study`: from a file to a store, a picture and NetCDF; what is refused, and the exit status of what failed."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.cli.conftest import Command

TEXT = """
name = "small"
scene = "studied.toml"
[task]
run = "simulate"
t = 0.5
[parameters]
gravity = 9.81
[grid]
"task.lean" = {{ from = 0.1, to = 0.5, count = 3 }}
"task.method" = [{methods}]
"""


@pytest.fixture
def plan(tmp_path: Path) -> Path:
    from tests.studies.conftest import SCENE

    (tmp_path / "studied.toml").write_text(SCENE.to_toml())
    (tmp_path / "study.toml").write_text(TEXT.format(methods='"auto"'))
    return tmp_path / "study.toml"


def test_a_study_is_computed_drawn_and_gone_on_with(command: Command, plan: Path, tmp_path: Path) -> None:
    said = command("study", plan, "--plan")
    assert said.code == 0 and "3 tasks of simulate" in said.out and not (tmp_path / "small.zarr").exists()
    words = ("study", plan, "--workers", 0, "--out", "kept.zarr")
    first = command(*words, "--netcdf", "small.nc")
    assert first.code == 0 and "3 computed, 0 failed" in first.out, first.err
    assert (tmp_path / "small.nc").stat().st_size > 1000
    plan.write_text(plan.read_text().replace('"task.method" = ["auto"]\n', ""))
    again = command(*words, "--picture", "small.png", "--of", "q[1]")
    assert again.code == 0 and "3 found in the store, 0 computed" in again.out, again.err
    assert (tmp_path / "small.png").stat().st_size > 10_000
    wrong = command(*words, "--picture", "small.png", "--of", "qq")
    assert wrong.code == 2 and 'did you mean "q"' in wrong.err


def test_failed_tasks_have_a_status_of_their_own(command: Command, plan: Path) -> None:
    plan.write_text(TEXT.format(methods='"auto", "no_such"'))
    answer = command("study", plan, "--workers", 0)
    assert answer.code == 3 and "3 failed" in answer.out and "no_such" in answer.out


@pytest.mark.parametrize(("words", "said"), [(("--picture", "a.jpg"), "suffix"), (("--netcdf", "a.txt"), "suffix"), (("--workers", "-1"), "workers")])
def test_what_cannot_be_written_is_refused_before_the_work(command: Command, plan: Path, words: tuple[str, ...], said: str, tmp_path: Path) -> None:
    answer = command("study", plan, *words)
    assert answer.code == 2 and said in answer.err and not (tmp_path / "small.zarr").exists()
