"""Every third-party import is declared, and every declared dependency is justified in CONTRIBUTING.md."""

from __future__ import annotations

import ast
import re
import sys
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]


def names(requirements: list[str]) -> set[str]:
    return {re.split(r"[\s<>=\[;~!]", line, maxsplit=1)[0].lower() for line in requirements}


CORE = names(PROJECT["dependencies"])
EXTRAS = {extra: names(lines) for extra, lines in PROJECT["optional-dependencies"].items()}


#: Packages whose import has another name.
PACKAGES = {"PIL": "pillow", "tomli_w": "tomli-w"}


def imported(path: Path) -> set[str]:
    """Top-level names imported anywhere in a file, inside functions too."""
    found: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            found |= {alias.name.split(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.level == 0 and node.module:
            found.add(node.module.split(".")[0])
    return {PACKAGES.get(name, name) for name in found}


def test_the_package_imports_only_what_it_declares() -> None:
    allowed = CORE | EXTRAS["casadi"] | EXTRAS["control"] | EXTRAS["plot"] | EXTRAS["study"] | {"phichain"} | set(sys.stdlib_module_names)
    for path in sorted((ROOT / "codegen").rglob("*.py")):
        assert imported(path) <= allowed, path


@pytest.mark.long
def test_every_dependency_is_used_or_is_a_tool() -> None:
    used = set().union(*(imported(path) for path in (ROOT / "codegen").rglob("*.py")))
    assert used >= CORE | EXTRAS["casadi"] | EXTRAS["control"] | EXTRAS["plot"] | EXTRAS["study"]


def test_core_dependencies_stay_few() -> None:
    assert CORE == {"numpy", "scipy", "sympy", "mpmath", "jinja2", "typer", "rich", "tomli-w"}


@pytest.mark.parametrize("package", sorted(CORE.union(*EXTRAS.values()) - {"phichain"}))
def test_every_dependency_is_justified(package: str) -> None:
    table = (ROOT / "CONTRIBUTING.md").read_text().split("## Dependencies")[1]
    assert re.search(rf"^\|.*\b{re.escape(package)}\b", table, re.MULTILINE)


TEXT = {".py", ".toml", ".md", ".j2", ".c", ".h", ".json", ".txt", ".html", ".js", ""}


def test_no_file_names_a_registry_or_a_folder_of_this_machine() -> None:
    foreign = ("pypi." + "org", "python" + "hosted", f"{ROOT}/", f"{Path.home()}/")
    tops = ("codegen", "templates", "stencils", "scenes", "docs", "examples", "tests", "benchmarks", ".ci")
    files = [path for top in tops for path in (ROOT / top).rglob("*") if path.suffix in TEXT and path.is_file()]
    files += [path for path in ROOT.iterdir() if path.is_file()]
    for path in files:
        text = path.read_text(errors="replace")
        assert not [word for word in foreign if word in text], path
