"""Connections between upright equilibria: their way over the links' angles, and each angle over time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from phichain.report import panels
from phichain.report.geometry import Drawn, tilt
from phichain.report.style import INK, SOFT, figure, look, shades

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from phichain.orbits.connections import Connection

_MOST = 6
"""So many are drawn, the quickest ones: more cannot be told apart."""


def connections(system: Drawn, found: Sequence[Connection]) -> Figure:
    """The quickest connections found: over the links' angles (one link: angle and rate), over time, and the chain on the first of them."""
    drawn = list(found)[:_MOST]
    with look():
        drawing = figure(9.6, 4.4)
        axes = drawing.subplot_mosaic([["way", "time", "chain"]], width_ratios=(1.2, 1.3, 1.0))
        for connection, colour in zip(drawn, shades(len(drawn)), strict=True):
            phi = tilt(system, connection.q) / np.pi
            across = phi[:, 1] if system.links > 1 else connection.v[:, -1]
            axes["way"].plot(phi[:, 0], across, color=colour)
            for k, style in zip(range(system.links), ("-", "--"), strict=False):
                axes["time"].plot(connection.t, phi[:, k], style, color=colour, label=_label(connection, k) if connection is drawn[0] else None)
        _equilibria(axes["way"], system, drawn)
        axes["time"].set(xlabel="t (s)", ylabel=r"angle from hanging, over $\pi$")
        axes["time"].legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=2, borderaxespad=0.2)
        panels.chain_in_motion(axes["chain"], system, drawn[0].q)
        axes["chain"].set_title(f"the quickest, {drawn[0].t[-1] - drawn[0].t[0]:.2f} s")
        left = f", {len(found) - len(drawn)} more not drawn" if len(found) > len(drawn) else ""
        axes["way"].set_title(f"{len(found)} connection(s) of {drawn[0].name}{left}", fontsize=9)
    return drawing


def _label(connection: Connection, k: int) -> str:
    return f"link {k + 1}, {connection.turns[k]:+d} turn(s)"


def _equilibria(axes: Any, system: Drawn, drawn: Sequence[Connection]) -> None:
    """Both ends, and the equilibrium half way."""
    ends = np.array([tilt(system, connection.q[[0, -1]]) for connection in drawn]).reshape(-1, system.links) / np.pi
    if system.links == 1:
        axes.plot(ends[:, 0], 0 * ends[:, 0], "o", color=INK, markersize=5)
        axes.set(xlabel=r"angle from hanging, over $\pi$", ylabel="rate (rad/s)")
        return
    middle = np.mean(ends[:2], axis=0)
    axes.plot(*ends.T, "o", color=INK, markersize=5)
    axes.plot(*middle, "o", color=SOFT, markersize=5, markerfacecolor="white")
    axes.set(xlabel=r"link 1 from hanging, over $\pi$", ylabel=r"link 2 from hanging, over $\pi$")
