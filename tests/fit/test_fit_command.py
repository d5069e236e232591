"""`phichain fit` from a file to files."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from phichain.scene import load_scene
from tests.cli.conftest import Command, cache_folder, command  # noqa: F401 - fixtures
from tests.fit.measured import DOUBLE, TOLD, swung_briefly

WORDS = ("--start", "mass=0.3,0.2", "--start", "com=0.15,0.1", "--start", "inertia=0.004,0.0014", "--start", "damping=0.003,0.0006")
FIXED = ("--fix", "mass_1", "--fix", "mass_2", "--fix", "com_1")


@pytest.fixture
def measured(tmp_path: Path) -> Path:
    made = swung_briefly().noisy(1e-3, 4)
    (tmp_path / "double.toml").write_text(DOUBLE.to_toml())
    np.savetxt(tmp_path / "data.csv", np.column_stack(list(made.values())), delimiter=",", header=",".join(made), comments="")
    return tmp_path


@pytest.mark.long
def test_all_files_are_written(command: Command, measured: Path) -> None:  # noqa: F811
    names = ("fit.json", "fit.csv", "fit.png", "fitted.toml")
    answer = command("fit", "double.toml", "data.csv", *WORDS, *FIXED, *(word for name in names for word in ("--out", name)))
    assert answer.code == 0, answer.err
    assert "inertia_2" in answer.out and "standard error" in answer.out
    result = json.loads((measured / "fit.json").read_text())
    for name, value, error in zip(result["names"], result["values"], result["standard_error"], strict=True):
        assert name not in TOLD or abs(value - TOLD[name]) < 4 * error
    assert (measured / "fit.png").read_bytes().startswith(b"\x89PNG")
    first = (measured / "fitted.toml").read_text().partition("\n")[0]
    assert {"phichain", "digest", "p", "method"} <= json.loads(first.removeprefix("# ")).keys(), "where it comes from, as a comment"
    scene = load_scene(measured / "fitted.toml")
    assert not scene.runtime and scene.com == (0.15, result["values"][0])
    assert result["digest"] == DOUBLE.digest


@pytest.mark.parametrize(
    ("words", "problem"),
    [
        (("data.csv", *WORDS), "cannot be told apart"),
        (("data.csv", *WORDS[:2], *FIXED[:2]), "start it (--start com=...)"),
        (("nothing.csv", *WORDS, *FIXED), "cannot be read"),
        (("data.csv", *WORDS, *FIXED, "--keep-state"), "give --x0 too"),
        (("data.csv", *WORDS, *FIXED, "--out", "fit.txt"), "suffix"),
    ],
)  # fmt: skip
def test_refusals_are_one_line_and_leave_nothing(command: Command, measured: Path, words: tuple[str, ...], problem: str) -> None:  # noqa: F811
    before = sorted(measured.iterdir())
    answer = command("fit", "double.toml", *words, "--out", "fit.json", "--out", "fit.png")
    assert answer.code == 2 and problem in answer.err and answer.err.count("\n") == 1
    assert sorted(measured.iterdir()) == before
