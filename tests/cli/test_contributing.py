"""What CONTRIBUTING and the docs say of the tree is there: every folder by its name, every path that a page names."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PACKAGE = ROOT / "codegen" / "phichain"
CONTRIBUTING = (ROOT / "CONTRIBUTING.md").read_text()
PAGES = (
    "README.md", "CONTRIBUTING.md", "docs/theory.md", "docs/functions.md", "docs/rigs.md", "docs/gallery.md", "docs/inputs.md", "docs/families.md",
    "docs/controllers.md", "docs/control.md", "docs/fit.md", "docs/firmware.md", "docs/performance.md", "benchmarks/README.md", "generated/README.md",
)  # fmt: skip


def drawn_tree() -> dict[str, str]:
    """What each path of the tree is said to be, by its path from the top."""
    layout = CONTRIBUTING[CONTRIBUTING.index("## Layout") : CONTRIBUTING.index("## Adding a function")]
    found: dict[str, str] = {}
    above: list[tuple[int, str]] = []
    for line in layout.splitlines():
        match = re.fullmatch(r"    ( *)([\w/.]+)  +(\S.*)", line)
        if match is None:
            continue
        depth, name, said = len(match[1]), match[2], match[3]
        above = [(level, path) for level, path in above if level < depth]
        path = f"{above[-1][1] if above else ''}{name}"
        above.append((depth, path))
        found[path] = said
    return found


def test_the_tree_names_every_folder_of_the_package_and_no_other() -> None:
    folders = {path.parent for path in PACKAGE.rglob("*.py")} - {PACKAGE}
    drawn = {path for path in drawn_tree() if path.startswith("codegen/phichain/") and path.endswith("/")}
    assert drawn - {"codegen/phichain/"} == {f"{folder.relative_to(ROOT)}/" for folder in folders}


def test_what_the_tree_names_is_there() -> None:
    assert [path for path in drawn_tree() if not (ROOT / path).exists()] == []


@pytest.mark.parametrize("page", PAGES)
def test_paths_on_pages_lead_somewhere(page: str) -> None:
    """`folder/file.py` is read from the top, from the package, or from the page's own folder."""
    text = (ROOT / page).read_text()
    named = set(re.findall(r"`((?:[a-z_0-9]+/)+[a-z_0-9]*(?:\.(?:py|md|c|h|json|toml|html))?)`", text))
    homes = (ROOT, PACKAGE, (ROOT / page).parent)
    lost = [path for path in named if not any((home / path).exists() for home in homes)]
    assert [path for path in lost if not WRITTEN.match(path)] == []


#: What phichain writes below generated/.
WRITTEN = re.compile(r"(generated/)?(planar4|planar3_cart_controller|report|figures)/")


def test_docstrings_name_modules_that_are_there() -> None:
    """`package.module` in a docstring or a remark is a module of the package, or a name in one."""
    folders = sorted({path.parent.name for path in PACKAGE.rglob("*.py")} - {PACKAGE.name, "chain"})  # a scene has a table chain
    pattern = re.compile(rf"`((?:{'|'.join(folders)})(?:\.[a-z_0-9]+)+)`")
    named = {(file, name) for file in PACKAGE.rglob("*.py") for name in pattern.findall(file.read_text())}
    assert len(named) > 5
    assert [f"{file.relative_to(PACKAGE)}: {name}" for file, name in named if not is_there(file, name)] == []


def is_there(file: Path, name: str) -> bool:
    """Whether a dotted name leads to a module, read from the package or from a folder around the file."""
    homes = [home for home in file.parents if home == PACKAGE or PACKAGE in home.parents]
    places = [home.joinpath(*name.split(".")) for home in homes]
    return any(
        place.is_dir() or place.with_suffix(".py").exists() or place.parent.with_suffix(".py").exists() for place in places
    )
