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
    for name in ("Makefile", "README.md", "LICENSE", "NOTICE", "CITATION.cff", "CHANGELOG.md", "docs/start.md", "docs/site/conf.py", "docs/notebooks/first_chain.md", "docs/figures/table.py", "docs/img/theory/chain.svg", "docs/img/moving.gif", "tests/conftest.py", "stencils/fmi/fmi3.c"):
        assert (unpacked / name).is_file(), name
    assert not list(unpacked.rglob("__pycache__")) and not list(unpacked.rglob(".venv"))


def test_the_built_site_is_in_the_source_archive_though_the_repository_ignores_it(tmp_path: Path) -> None:
    tree = tmp_path / "tree"
    for name in ("pyproject.toml", "README.md", "LICENSE", "NOTICE", ".gitignore", "codegen/phichain/_version.py"):
        (tree / name).parent.mkdir(parents=True, exist_ok=True)
        (tree / name).write_bytes((ROOT / name).read_bytes())
    for name in ("generated/site/index.html", "generated/report/index.html"):
        (tree / name).parent.mkdir(parents=True)
        (tree / name).write_text("<html></html>")
    with tarfile.open(built("sdist", tree, tmp_path)) as archive:
        held = [name.partition("/")[2] for name in archive.getnames() if "/generated/" in name]
    assert held == ["generated/site/index.html"]


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


def test_windows_is_told_plainly_wherever_it_is_looked_for() -> None:
    """In one sentence by the import itself, in the README, on the first page of the tutorial, and to registries."""
    words = "import sys; sys.platform = 'win32'; import phichain"
    done = subprocess.run([sys.executable, "-c", words], cwd=ROOT / "codegen", capture_output=True, text=True, check=False)
    assert done.stderr.strip().splitlines()[-1].startswith("ImportError: phichain runs on Linux and macOS and not on Windows") and "WSL" in done.stderr
    assert all("WSL" in (ROOT / page).read_text() for page in ("README.md", "docs/start.md"))
    systems = [line for line in tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["classifiers"] if line.startswith("Operating System")]
    assert systems == ["Operating System :: MacOS", "Operating System :: POSIX :: Linux"]


def test_no_address_of_the_project_is_pretended() -> None:
    """There is none yet: a registry, a page that links to one, or a citation would send people to a place that is not there."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    assert "urls" not in project
    citation = (ROOT / "CITATION.cff").read_text()
    assert not [key for key in ("url:", "repository", "repository-code:") if key in citation]
    for page in ("README.md", "docs/start.md", "docs/studies.md"):
        assert "pip install phichain\n" not in (ROOT / page).read_text(), f"{page} asks a registry for it"
