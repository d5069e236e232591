"""Every figure of docs/theory.md by its name, and how one becomes a file."""

from __future__ import annotations

import io
import re
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any, Final

import matplotlib
from matplotlib.figure import Figure

ROOT: Final = Path(__file__).resolve().parents[2]
FOLDER: Final = ROOT / "docs" / "img" / "theory"
MODULES: Final = ("chains", "planar", "ends", "spatial", "orbits", "checks", "steps", "implicit", "flow")
"""The modules that draw, in the order of the page's sections."""
_LOOK: Final[dict[str, Any]] = {
    "font.size": 9.0,
    "font.family": "DejaVu Sans",
    "mathtext.fontset": "cm",
    "svg.fonttype": "path",
    "svg.hashsalt": "phichain",
    "lines.solid_capstyle": "round",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.labelsize": 9.0,
    "legend.frameon": False,
}
_OUTLINE: Final = re.compile(rb' d="[^"]*"')
_DECIMALS: Final = re.compile(rb"-?\d+\.\d+")
Draw = Callable[[], Figure]
_FIGURES: dict[str, Draw] = {}


def figure(name: str) -> Callable[[Draw], Draw]:
    """Put a function without arguments into the table: it draws the figure of this name."""

    def put(draw: Draw) -> Draw:
        assert name not in _FIGURES, f"two figures are called {name}"
        _FIGURES[name] = draw
        return draw

    return put


def figures() -> dict[str, Draw]:
    """Name -> what draws it."""
    for module in MODULES:
        import_module(f"docs.figures.{module}")
    return dict(_FIGURES)


def written(draw: Draw, kind: str = "svg") -> bytes:
    """A figure as the bytes of a file: glyphs as outlines, no date, nothing drawn by chance.

    Args:
        draw: one of `figures()`.
        kind: "svg", or "png" to look at.
    """
    file = io.BytesIO()
    with matplotlib.rc_context(_LOOK):
        metadata: dict[str, Any] = {"Creator": creator(), "Date": None} if kind == "svg" else {}
        draw().savefig(file, format=kind, dpi=144, facecolor="white", metadata=metadata)
    return _OUTLINE.sub(_rounded, file.getvalue()) if kind == "svg" else file.getvalue()


def _rounded(outline: re.Match[bytes]) -> bytes:
    """An outline in hundredths of a point: finer digits may differ from processor to processor."""
    return _DECIMALS.sub(lambda number: b"%g" % round(float(number[0]), 2), outline[0])


def creator() -> str:
    """What drew a file, which the file says."""
    return f"docs.figures, Matplotlib {matplotlib.__version__}"


def write(folder: Path = FOLDER, kind: str = "svg") -> list[Path]:
    """Write every figure; returns their paths."""
    folder.mkdir(parents=True, exist_ok=True)
    paths = []
    for name, draw in figures().items():
        paths.append(folder / f"{name}.{kind}")
        paths[-1].write_bytes(written(draw, kind))
    return paths
