"""What the README says works: its scene, its C, its Python, its commands and its links."""

from __future__ import annotations

import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from phichain.pipeline import generate
from phichain.scene import load_scene, standard_scene
from tests.cli.conftest import Command

ROOT = Path(__file__).parents[2]
README = (ROOT / "README.md").read_text()


def blocks(language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```", README, re.MULTILINE | re.DOTALL)


@pytest.fixture(scope="module")
def planar4(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return generate(standard_scene(4), tmp_path_factory.mktemp("readme"))


def test_the_scene_is_one(tmp_path: Path) -> None:
    (text,) = blocks("toml")
    (tmp_path / "crane.toml").write_text(text)
    scene = load_scene(tmp_path / "crane.toml")
    assert scene.name == "crane" and scene.runtime == ("cart_mass",)


@pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler called cc")
def test_the_c_compiles_and_runs(planar4: Path, tmp_path: Path) -> None:
    (text,) = blocks("c")
    include, statements = text.split("\n", 1)
    checked = "return a[0] < 0.0 ? 0 : 1;"  # a chain that leans to the right falls back to the left
    (tmp_path / "main.c").write_text(f"{include}\nint main(void)\n{{\n{statements}\n{checked}\n}}\n")
    sources = [tmp_path / "main.c", planar4 / "planar4.c"]
    words = ["cc", "-std=c99", "-Wall", "-Werror", "-I", planar4, *sources, "-lm", "-o", tmp_path / "main"]
    subprocess.run([str(word) for word in words], check=True)
    subprocess.run([str(tmp_path / "main")], check=True)


@pytest.mark.parametrize("number", range(len(blocks("python"))))
def test_the_python_runs(number: int, planar4: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-c", blocks("python")[number]], cwd=planar4, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("line", re.findall(r"^    (phichain [a-z]+ .*|phichain info).*$", README, re.MULTILINE))
def test_the_commands_work(command: Command, line: str) -> None:
    words = shlex.split(line.split(" #")[0])[1:]
    answer = command(*(word.replace("SCENE", "planar4").replace("DIR", "out") for word in words))
    assert answer.code == 0, answer.err


def test_the_targets_of_make_exist() -> None:
    makefile = (ROOT / "Makefile").read_text()
    for target in re.findall(r"^ {4}make ([a-z-]+)", README, re.MULTILINE):
        assert re.search(rf"^{target}:", makefile, re.MULTILINE), target


def test_links_lead_somewhere() -> None:
    for link in re.findall(r"\]\(([^)]+)\)", README):
        assert link.startswith("https://") or (ROOT / link).exists(), link

