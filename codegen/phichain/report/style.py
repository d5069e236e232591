"""How every figure of phichain looks: one set of sizes and colours, no window, no global state.

Figures are made as objects and written as PNG; nothing here touches pyplot, so a report can be drawn from any thread
and beside any other use of matplotlib. matplotlib belongs to the extra `plot` and is imported when first needed.
"""

from __future__ import annotations

import io
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from phichain.errors import UnsupportedError
from phichain.files import write_file
from phichain.report.origins import metadata, told

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_LOOK: Any = {
    "font.size": 9.0,
    "axes.titlesize": 10.0,
    "axes.titlelocation": "left",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": "#e3e7ec",
    "grid.linewidth": 0.7,
    "lines.linewidth": 1.3,
    "legend.frameon": False,
    "legend.fontsize": 8.0,
}

ACCENT = "#c2410c"
INK = "#1c2430"
SOFT = "#8b95a3"


@contextmanager
def look() -> Iterator[None]:
    """Draw in the project's style within this block.

    Raises:
        UnsupportedError: matplotlib is not installed.
    """
    try:
        import matplotlib
    except ImportError as failure:
        raise UnsupportedError(
            "figure", "matplotlib", "needs a package that is not installed", "pip install 'phichain[plot]'"
        ) from failure
    with matplotlib.rc_context(_LOOK):
        yield


def figure(width: float = 7.2, height: float = 4.2) -> Figure:
    """An empty figure of that size in inches, without a window, that a notebook shows; call it inside `look`."""
    from phichain.report.drawn import Drawing

    return Drawing(figsize=(width, height), layout="constrained")


def shades(count: int) -> list[Any]:
    """One colour per link from base to tip, dark to light, told apart in grey print too."""
    from matplotlib import colormaps

    return [colormaps["viridis"](at) for at in np.linspace(0.0, 0.85, max(count, 1))]


def save(drawing: Figure, path: str | Path, dpi: int = 150, of: Any = None) -> Path:
    """Write a figure as PNG, SVG or PDF, by the name of the file, whole or not at all.

    Args:
        drawing: The figure.
        path: The file.
        dpi: Points per inch of a PNG.
        of: The record that it shows, or several: the file says where they come from.

    Raises:
        OutputError: The file cannot be written.
    """
    text, kind = told(of), Path(path).suffix
    return write_file(path, _vectors(drawing, kind, text) if kind in _VECTORS else png(drawing, dpi, text))


def png(drawing: Figure, dpi: int = 150, text: str = "") -> bytes:
    """A figure as PNG, with where it comes from."""
    buffer = io.BytesIO()
    drawing.savefig(buffer, format="png", dpi=dpi, metadata=metadata(".png", text or told()))
    return buffer.getvalue()


_VECTORS = (".svg", ".pdf")


def _vectors(drawing: Figure, kind: str, text: str) -> bytes:
    """A figure in lines."""
    import matplotlib

    buffer = io.BytesIO()
    with matplotlib.rc_context({"svg.hashsalt": "phichain"}):
        drawing.savefig(buffer, format=kind[1:], metadata=metadata(kind, text))
    return buffer.getvalue()
