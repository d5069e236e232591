"""The gallery by sphinx-gallery: every script of examples/, its output and its picture; the figures of both papers in front."""

from __future__ import annotations

import re
import shutil
from pathlib import Path
from typing import Any, Final

LONG: Final = ("swing_up",)
"""Scripts that take too long to be run with the site: they show a committed picture."""
FOLDER: Final = "gallery"
"""Where the pages are, in the staged tree."""
_SECTION: Final = re.compile(r"^## ([^\n]+)$(.*?)(?=^## |\Z)", re.MULTILINE | re.DOTALL)
_PICTURE: Final = re.compile(r"!\[([^\]]*)\]\((img/[\w.-]+)\)")


def settings(source: Path) -> dict[str, Any]:
    """What sphinx-gallery is told; `source` is the staged tree."""
    return {
        "examples_dirs": str(source / "examples"),
        "gallery_dirs": FOLDER,
        "filename_pattern": rf"/(?!(?:{'|'.join(LONG)})\.py$)\w+\.py$",
        "image_scrapers": ("docs.site.gallery.saved",),
        "reset_modules": (),
        "capture_repr": (),
        "download_all_examples": False,
        "remove_config_comments": True,
        "show_signature": False,
        "write_computation_times": False,
        "min_reported_time": 3600,
        "within_subsection_order": "FileNameSortKey",
    }


def stage(root: Path, out: Path) -> None:
    """Copy the scripts and write the head of the gallery."""
    folder = out / "examples"
    folder.mkdir(parents=True, exist_ok=True)
    for script in sorted((root / "examples").glob("*.py")):
        shutil.copyfile(script, folder / script.name)
    for picture in (root / "docs" / "img" / f"{name}_two.png" for name in LONG):
        (out / "docs" / "img").mkdir(parents=True, exist_ok=True)
        shutil.copyfile(picture, out / "docs" / "img" / picture.name)
    (folder / "GALLERY_HEADER.rst").write_text(head(root))


def head(root: Path) -> str:
    """The first page: a thumbnail for each figure of both papers, then the scripts."""
    text = (root / "docs" / "gallery.md").read_text()
    parts = ["Gallery", "=======", "", "Figures of both papers", "----------------------", "", "How to read each of them, and how it is drawn: :doc:`/docs/gallery`.", ""]
    for title, body in _SECTION.findall(text):
        picture = _PICTURE.search(body)
        if picture:
            parts += [f".. image:: /docs/{picture[2]}", f"   :alt: {title}", "   :width: 23%", f"   :target: ../docs/gallery.html#{slug(title)}", ""]
    parts += ["Scripts", "-------", "", "Each runs alone from any folder; `make figures` runs them all. What they print and draw here is from this site's build.", ""]
    return "\n".join(parts)


def slug(title: str) -> str:
    """The anchor that a heading has."""
    return re.sub(r"[^\w\- ]", "", title.lower()).strip().replace(" ", "-")


def without_folders(app: Any, docname: str, source: list[str]) -> None:
    """Take the folder of the build from what scripts print of the files that they wrote; told by Sphinx when it reads a page."""
    if docname.startswith(f"{FOLDER}/"):
        source[0] = source[0].replace(f"{app.srcdir}/examples/", "")


def saved(block: Any, block_vars: dict[str, Any], gallery_conf: dict[str, Any]) -> str:
    """Pictures that a script has written under generated/figures, each shown once, as reStructuredText."""
    from sphinx_gallery.scrapers import figure_rst

    found = []
    for path in sorted(Path("generated", "figures").glob("*.png")):
        target = Path(next(block_vars["image_path_iterator"]))
        shutil.move(path, target)
        found.append(str(target))
    rst: str = figure_rst(found, gallery_conf["src_dir"])
    return rst
