"""How far regulators hold: radii of all equilibria, and a map of one."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from phichain.report.style import figure, look

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from phichain.control.reach import Attraction, AttractionMap


def radii(record: Attraction) -> Figure:
    """Radii of attraction of all equilibria, by size, with the direction that fails first."""
    with look():
        order = np.argsort(-record.radius)
        drawing = figure(7.2, 1.6 + 0.22 * len(order))
        axes = drawing.subplots()
        names = ["".join("↓" if sign > 0 else "↑" for sign in record.s[k]) for k in order]
        axes.barh(np.arange(len(order)), record.radius[order], color="C0")
        axes.set_yticks(np.arange(len(order)), names)
        axes.margins(y=0.01)
        axes.invert_yaxis()
        axes.set_xscale("log")
        axes.set_xlabel(f"radius from which {record.directions} directions came home within {record.seconds:g} s")
        axes.set_title(f"{record.name}: regions of attraction")
    return drawing


def region(mapped: AttractionMap, record: Attraction | None = None) -> Figure:
    """A map of one region of attraction: when starts come home, and the ball in which all directions did where that is known."""
    with look():
        drawing = figure(6.2, 5.2)
        axes = drawing.subplots()
        came = np.where(mapped.verdict == 1, mapped.time, np.nan)
        image = axes.pcolormesh(mapped.axis, mapped.axis, came, shading="nearest", cmap="viridis", vmin=0)
        axes.set_facecolor("0.85")
        axes.grid(visible=False)
        drawing.colorbar(image, ax=axes, label="home after (s)")
        if record is not None:
            turn = np.linspace(0, 2 * np.pi, 181)
            axes.plot(record.radius[0] * np.cos(turn), record.radius[0] * np.sin(turn), "w--", linewidth=1.2)
        axes.set_xlabel(mapped.coordinates[0])
        axes.set_ylabel(mapped.coordinates[1])
        axes.set_aspect("equal")
        dashed = "" if record is None else "; dashed: from there all directions came home"
        axes.set_title(f"{mapped.name}, s = {list(mapped.s)}{dashed}", fontsize="small")
    return drawing
