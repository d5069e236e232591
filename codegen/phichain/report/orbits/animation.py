"""An orbit in motion: a GIF, or one HTML file that opens anywhere and needs nothing."""

from __future__ import annotations

import io
import json
import re
from html import escape
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from phichain.files import write_file
from phichain.report.geometry import Drawn, joints
from phichain.report.origins import in_gif, in_page, told
from phichain.report.style import ACCENT, INK, SOFT, figure, look

if TYPE_CHECKING:
    from phichain.orbits import Orbit

FRAMES = 60
"""Pictures of one period."""
_SHORTEST, _LONGEST = 1.0, 6.0
"""Seconds that a period is shown in at least and at most."""
_VIEW = np.radians(20.0)
"""How far from above the horizon a spatial chain is seen."""


def seen(system: Drawn, found: Orbit) -> NDArray[np.float64]:
    """Points from the base to the tip on the paper (m, N + 1, 2), m to the right and upwards."""
    points = joints(system, found.q)
    if system.is_planar:
        return np.stack([points[..., 0], -points[..., 1]], axis=-1)
    return np.stack([points[..., 0], -np.cos(_VIEW) * points[..., 2] + np.sin(_VIEW) * points[..., 1]], axis=-1)


def shown_for(found: Orbit) -> float:
    """Seconds in which one period is shown: its own, within bounds."""
    return float(np.clip(found.period, _SHORTEST, _LONGEST))


def write_gif(system: Drawn, found: Orbit, path: Path | str) -> Path:
    """Write one period as a GIF that runs for ever, whole or not at all.

    Raises:
        UnsupportedError: matplotlib is not installed.
        OutputError: The file cannot be written.
    """
    points = seen(system, found)
    frames = np.round(np.linspace(0, len(points) - 1, min(FRAMES, len(points) - 1), endpoint=False)).astype(int)
    with look():
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from PIL import Image

        drawing = figure(3.6, 3.6)
        canvas = FigureCanvasAgg(drawing)
        axes: Any = drawing.subplots()
        low, high = _bounds(points)
        axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal")
        axes.set_axis_off()
        axes.plot(points[:, -1, 0], points[:, -1, 1], color=ACCENT, linewidth=0.7, alpha=0.6)
        if system.has_cart:
            axes.axhline(0.0, color=SOFT, linewidth=0.8)
        (chain,) = axes.plot([], [], "-o", color=INK, linewidth=1.8, markersize=4.5)
        pictures = []
        for k in frames:
            chain.set_data(points[k, :, 0], points[k, :, 1])
            canvas.draw()
            pictures.append(Image.fromarray(np.asarray(canvas.buffer_rgba())).convert("P", palette=Image.Palette.ADAPTIVE, colors=32))
    buffer = io.BytesIO()
    each = round(100 * shown_for(found) / len(frames)) * 10
    pictures[0].save(buffer, format="GIF", save_all=True, append_images=pictures[1:], duration=max(each, 20), loop=0)
    return write_file(path, in_gif(buffer.getvalue(), told(found)))


def write_page(system: Drawn, found: Orbit, path: Path | str) -> Path:
    """Write one period as an HTML page with a few lines of script, whole or not at all.

    Raises:
        OutputError: The file cannot be written.
    """
    return write_file(path, page(system, found))


def page(system: Drawn, found: Orbit) -> str:
    """The page as text: the chain in motion over the path of its tip, and what there is to say of the orbit."""
    points = seen(system, found)
    low, high = _bounds(points)
    data = {
        "points": np.round(points, 5).tolist(), "low": low.tolist(), "high": high.tolist(), "seconds": shown_for(found),
        "rail": system.has_cart,
    }  # fmt: skip
    rows = "".join(f"<tr><th>{escape(name)}</th><td>{escape(value)}</td></tr>" for name, value in found.rows().items())
    parts = {
        "title": escape(f"{found.scene}: T = {found.period:.6g} s"), "rows": rows, "origin": in_page(told(found)),
        # A "<" would end the script early, and JSON may say it otherwise.
        "data": json.dumps(data, separators=(",", ":")).replace("<", "\\u003c"),
    }  # fmt: skip
    template = files("phichain.report.orbits").joinpath("animation.html").read_text(encoding="utf-8")
    return re.sub(r"@(title|rows|origin|data)@", lambda found: parts[found[1]], template)


def _bounds(points: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """A square around all that is drawn, with a margin."""
    flat = points.reshape(-1, 2)
    middle, half = (flat.max(0) + flat.min(0)) / 2, 0.55 * float(np.max(np.ptp(flat, axis=0)))
    return middle - half, middle + half
