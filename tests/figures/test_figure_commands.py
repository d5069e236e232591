"""`phichain figure` and `phichain propagation`: what they leave, what they say, what they refuse."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import typer
from matplotlib.image import imread
from typer.testing import CliRunner

from phichain.app.commands.figures import register
from phichain.errors import UnsupportedError
from phichain.papers.figures import FIGURES

RUNNER = CliRunner()


@pytest.fixture(scope="module")
def app() -> typer.Typer:
    commands = typer.Typer()
    register(commands)
    return commands


def is_a_picture(path: Path) -> bool:
    pixels = imread(path)
    return (
        pixels.shape[0] > 300 and pixels.shape[1] > 800 and 0.05 < float(np.mean(pixels[..., :3].std())) < 0.5
    )


def test_every_figure_has_a_name() -> None:
    assert list(FIGURES) == ["A2", "A3", "A4", "A5", "A6", "A7", "B2", "B3", "B4", "E2", "E3", "E4", "G4", "N2", "C2", "U2"]


@pytest.mark.long
@pytest.mark.parametrize("name", ["A2", "a3"])
def test_a_figure_is_one_command_away(app: typer.Typer, name: str, tmp_path: Path) -> None:
    answer = RUNNER.invoke(app, ["figure", name, "--out", str(tmp_path)])
    assert answer.exit_code == 0, answer.output
    pictures = sorted(tmp_path.glob("*.png"))
    assert f"{name.upper()}.png" in {path.name for path in pictures} and all(map(is_a_picture, pictures))
    assert answer.output.startswith(f"{name.upper()}: wrote ")
    assert (tmp_path / "A3.html").exists() is (name == "a3")


def test_propagation_takes_any_planar_scene(app: typer.Typer, tmp_path: Path) -> None:
    words = [
        "propagation",
        "planar2",
        "--t",
        "0.3",
        "--samples",
        "61",
        "--q",
        "0.3,0.1",
        "--out",
        str(tmp_path),
    ]
    answer = RUNNER.invoke(app, words)
    assert answer.exit_code == 0, answer.output
    assert "61 times" in answer.output and "with initial terms" in answer.output
    assert all(is_a_picture(path) for path in tmp_path.glob("*.png"))
    assert {path.name for path in tmp_path.iterdir()} == {
        f"planar2_propagation{tail}" for tail in (".png", "_feedback.png", ".html")
    }


def test_unknown_names_and_spatial_scenes_are_refused(app: typer.Typer, tmp_path: Path) -> None:
    answer = RUNNER.invoke(app, ["figure", "A3", "A9", "--out", str(tmp_path)])
    assert isinstance(answer.exception, UnsupportedError) and "A2, A3" in str(answer.exception)
    answer = RUNNER.invoke(app, ["propagation", "paper_b", "--out", str(tmp_path)])
    assert isinstance(answer.exception, UnsupportedError) and "planar" in str(answer.exception)
    assert not any(tmp_path.iterdir())
