"""The tree that Sphinx reads: the repository's pages where they are, what they link to, and the references made from tables and docstrings."""

from __future__ import annotations

import re
import shutil
from collections.abc import Iterable
from pathlib import Path

from docs.site import gallery, reference

PAGES = ("README.md", "CONTRIBUTING.md", "CHANGELOG.md", "benchmarks/README.md", "generated/README.md")
_LINK = re.compile(r"(!?\[[^\]]*\])\(((?!https?:|mailto:|#)[^)#\s]+)(#[^)\s]*)?\)")
_ANCHOR = re.compile(r"^<a id=\"(\w+)\"></a>$", re.MULTILINE)


def pages(root: Path) -> list[Path]:
    """The repository's pages, in order."""
    docs = root / "docs"
    found = [*sorted(docs.glob("*.md")), *sorted((docs / "notebooks").glob("*.md")), *sorted((root / "benchmarks" / "results").glob("*.md"))]
    return [*(root / name for name in PAGES if (root / name).exists()), *found]


def dead(root: Path) -> list[str]:
    """Links of pages to files that are not there, one line each."""
    return [f"{page.relative_to(root)}: there is no {link}" for page in pages(root) for link in linked(page.read_text(), page.parent) if not link.exists()]


def stage(root: Path, out: Path) -> None:
    """Copy pages with what they link to, and write the index and the references."""
    found = pages(root)
    for page in found:
        target = out / page.relative_to(root)
        target.parent.mkdir(parents=True, exist_ok=True)
        text = page.read_text()
        target.write_text(_ANCHOR.sub(r"(\1)=", _without_folders(text, page.parent, root)))
        for path in linked(text, page.parent):
            if path.is_file() and path.suffix != ".md" and path.is_relative_to(root):
                copy = out / path.relative_to(root)
                copy.parent.mkdir(parents=True, exist_ok=True)
                shutil.copyfile(path, copy)
    (out / "reference").mkdir(parents=True, exist_ok=True)
    for name, text in reference.pages().items():
        (out / "reference" / name).write_text(text)
    gallery.stage(root, out)
    (out / "index.md").write_text(_index(root, found))


def linked(text: str, folder: Path) -> Iterable[Path]:
    """The files that a page links to."""
    return ((folder / match[2]).resolve() for match in _LINK.finditer(text))


def _without_folders(text: str, folder: Path, root: Path) -> str:
    """A page whose links to folders are plain words: a site has no page for them."""

    def plain(match: re.Match[str]) -> str:
        if (folder / match[2]).is_dir():
            return f"{match[1][1:-1]} (`{(folder / match[2]).resolve().relative_to(root)}/`)"
        return match[0]

    return _LINK.sub(plain, text)


LADDER = (
    ("Tutorial", tuple(f"docs/notebooks/{name}" for name in ("first_chain", "own_rig", "families", "control", "firmware", "studies"))),
    ("Learn", ("docs/start", "docs/rigs", "docs/controllers", "docs/inputs", "docs/fit", "docs/studies")),
    ("Understand", ("docs/theory", f"{gallery.FOLDER}/index", "docs/gallery")),
)
"""The tutorial's steps and the theory, by the names of their pages; pages that are not named stand under "More"."""


def _index(root: Path, found: list[Path]) -> str:
    """The first page: the README's first lines, then every page in its place."""
    names = [str(page.relative_to(root).with_suffix("")) for page in found]
    parts: list[tuple[str, list[str]]] = [(title, [name for name in wanted if name in names or name.startswith(gallery.FOLDER)]) for title, wanted in LADDER]
    parts.append(("Look up", [*(f"reference/{name.removesuffix('.md')}" for name in reference.NAMES), "docs/functions"]))
    results = [name for name in names if name.startswith("benchmarks/")]
    placed = {name for _, part in parts for name in part} | {*results, "README", "CONTRIBUTING", "CHANGELOG", "generated/README"}
    parts.append(("More", [name for name in names if name not in placed and name.startswith("docs/") and name != "docs/README"]))
    parts += [("Measured", results), ("The project", ["README", "CONTRIBUTING", "CHANGELOG", "generated/README"])]
    trees = [f"```{{toctree}}\n:caption: {title}\n:maxdepth: 1\n\n" + "\n".join(part) + "\n```" for title, part in parts if part]
    first = (root / "README.md").read_text().split("\n\n")[1]
    return "\n\n".join(["# phichain", first, *trees]) + "\n"
