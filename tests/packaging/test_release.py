"""What is released: the source archive holds what a wheel, the tests and the documentation are made from, and says its version once."""

from __future__ import annotations

import subprocess
import sys
import tarfile
import tomllib
import zipfile
from pathlib import Path

import pytest

import phichain

ROOT = Path(__file__).parents[2]


def built(kind: str, source: Path, out: Path) -> Path:
    subprocess.run([sys.executable, "-m", "hatchling", "build", "-t", kind, "-d", str(out)], cwd=source, check=True, capture_output=True)
    (found,) = out.glob("phichain-*.tar.gz" if kind == "sdist" else "phichain-*.whl")
    return found


@pytest.fixture(scope="module")
def unpacked(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("release")
    with tarfile.open(built("sdist", ROOT, folder)) as archive:
        archive.extractall(folder, filter="data")
    return folder / f"phichain-{phichain.__version__}"


def test_the_source_archive_holds_what_is_needed(unpacked: Path) -> None:
    for name in ("Makefile", "README.md", "LICENSE", "NOTICE", "CITATION.cff", "CHANGELOG.md", "docs/start.md", "docs/site/conf.py", "docs/img/moving.gif", "tests/conftest.py", "stencils/fmi3.c"):
        assert (unpacked / name).is_file(), name
    assert not list(unpacked.rglob("__pycache__")) and not list(unpacked.rglob(".venv"))


def test_a_wheel_from_the_archive_is_the_packages_files(unpacked: Path, tmp_path: Path) -> None:
    with zipfile.ZipFile(built("wheel", unpacked, tmp_path)) as wheel:
        names = {name for name in wheel.namelist() if name.endswith(".py")}
        package = {f"phichain/{path.relative_to(ROOT / 'codegen/phichain').as_posix()}" for path in (ROOT / "codegen/phichain").rglob("*.py")}
        assert names == package
        assert all(wheel.read(name) == (ROOT / "codegen" / name).read_bytes() for name in package)


def test_the_citation_says_the_version_and_licence_of_the_package() -> None:
    lines = dict(line.split(": ", 1) for line in (ROOT / "CITATION.cff").read_text().splitlines() if ": " in line and not line.startswith((" ", "-")))
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    assert lines["version"] == phichain.__version__ and lines["license"] == project["license"]
