"""A wheel, installed where nothing of the checkout is in reach, generates the same bytes as the checkout."""

from __future__ import annotations

import os
import subprocess
import sys
import sysconfig
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


def run(*words: str | Path, cwd: Path, path: str = "") -> subprocess.CompletedProcess[str]:
    """Run a command with an environment that cannot find the checkout."""
    environment = {k: v for k, v in os.environ.items() if not k.startswith(("PYTHON", "PYTEST", "COV_"))}
    if path:
        environment["PYTHONPATH"] = path
    done = subprocess.run([str(word) for word in words], cwd=cwd, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, f"{words}\n{done.stdout}\n{done.stderr}"
    return done


def environment_in(folder: Path) -> Path:
    """A new environment that borrows this one's third-party packages, without its .pth files, so no checkout."""
    run(sys.executable, "-m", "venv", "--without-pip", folder, cwd=folder.parent)
    version = f"python{sys.version_info.major}.{sys.version_info.minor}"
    site = folder / "lib" / version / "site-packages"
    site.joinpath("borrowed.pth").write_text(sysconfig.get_path("purelib") + "\n")
    return folder / "bin" / "python"


def folder_bytes(folder: Path) -> dict[str, bytes]:
    return {str(p.relative_to(folder)): p.read_bytes() for p in sorted(folder.rglob("*")) if p.is_file()}


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    target = tmp_path_factory.mktemp("wheel")
    run(sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", target, cwd=ROOT)
    (found,) = target.glob("phichain-*.whl")
    return found


@pytest.fixture(scope="module")
def checkout_folder(tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    out = tmp_path_factory.mktemp("checkout")
    words = (sys.executable, "-m", "phichain", "generate", "planar2", "--out", out)
    run(*words, cwd=out, path=str(ROOT / "codegen"))
    return folder_bytes(out / "planar2")


def test_wheel_holds_the_package_its_templates_and_scenes_and_nothing_else(wheel: Path) -> None:
    names = zipfile.ZipFile(wheel).namelist()
    scenes = {path.name for path in (ROOT / "scenes").glob("*.toml")}
    for folder in ("templates", "stencils"):
        files = {f"phichain/{path.relative_to(ROOT)}" for path in (ROOT / folder).rglob("*") if path.is_file()}
        assert {name for name in names if name.startswith(f"phichain/{folder}/")} == files
    assert {Path(n).name for n in names if n.startswith("phichain/scenes/") and n.endswith(".toml")} == scenes
    assert "phichain/py.typed" in names
    tops = {name.split("/")[0] for name in names}
    assert len(tops) == 2 and all(top.startswith("phichain") for top in tops)
    assert {"LICENSE", "NOTICE"} <= {Path(n).name for n in names if ".dist-info/" in n}


@pytest.mark.long
@pytest.mark.parametrize("kind", ["wheel", "editable"])
def test_an_installation_generates_the_checkouts_bytes_from_another_folder(
    kind: str, wheel: Path, checkout_folder: dict[str, bytes], tmp_path: Path
) -> None:
    python = environment_in(tmp_path / "env")
    what = [wheel] if kind == "wheel" else ["--editable", ROOT]
    pip = (sys.executable, "-m", "pip", "--python", python, "install", "--quiet", "--no-deps", "--no-build-isolation")
    run(*pip, *what, cwd=tmp_path)
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()

    where = run(python, "-c", "import phichain; print(phichain.__file__)", cwd=elsewhere).stdout
    assert Path(where).is_relative_to(tmp_path if kind == "wheel" else ROOT / "codegen")

    command = python.parent / "phichain"
    run(command, "generate", "planar2", "--out", "somewhere", cwd=elsewhere)
    assert folder_bytes(elsewhere / "somewhere" / "planar2") == checkout_folder
    assert [path.name for path in elsewhere.iterdir()] == ["somewhere"]


@pytest.mark.long
def test_a_wheel_brings_what_it_needs(wheel: Path, tmp_path: Path) -> None:
    """The declared dependencies suffice: nothing is borrowed, everything comes through pip."""
    run(sys.executable, "-m", "venv", tmp_path / "env", cwd=tmp_path)
    python = tmp_path / "env" / "bin" / "python"
    words = [python, "-m", "pip", "install", "--quiet", "--no-compile", "--disable-pip-version-check", wheel]
    install = subprocess.run([str(word) for word in words], cwd=tmp_path, capture_output=True, text=True, check=False)
    if "No matching distribution" in install.stderr or "connection" in install.stderr.lower():
        pytest.skip("no package index in reach")
    assert install.returncode == 0, install.stderr
    run(python, "-m", "phichain", "generate", "planar2", "--out", "out", cwd=tmp_path)
    text = run(python, "-m", "phichain", "build", "planar2", cwd=tmp_path).stdout
    assert "forward_dynamics" in text
