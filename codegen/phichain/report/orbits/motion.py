"""One orbit: the chain at some moments of its period, its angles, and where its multipliers lie."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from phichain.report import panels
from phichain.report.geometry import Drawn, joints, tilt
from phichain.report.style import ACCENT, INK, SOFT, figure, look

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from phichain.orbits import Orbit


def orbit(system: Drawn, found: Orbit) -> Figure:
    """The chain over one period, how its links move in time, and the multipliers beside the unit circle."""
    with look():
        drawing = figure(9.4, 4.2)
        axes = drawing.subplot_mosaic([["chain", "angles", "circle"]], width_ratios=(1.0, 1.4, 0.9))
        if system.is_planar:
            panels.chain_in_motion(axes["chain"], system, found.q)
        else:
            _from_above(axes["chain"], system, found)
        axes["chain"].set_title(f"T = {found.period:.6g} s")
        names = [f"link {k}" for k in range(1, system.links + 1)]
        if system.is_planar:
            panels.against_time(axes["angles"], found.t, tilt(system, found.q), names, "link angle (rad)")
        else:
            # Angles from the vertical stay as they are where a chain turns as if it were stiff.
            panels.against_time(axes["angles"], found.t, joints(system, found.q)[:, 1:, 0], names, "end of the link along $e_1$ (m)")
        axes["angles"].set_xlabel("t (s)")
        _circle(axes["circle"], found)
    return drawing


def _from_above(axes: Any, system: Drawn, found: Orbit) -> None:
    """The paths of the joints and the chain at its start, from above."""
    points = joints(system, found.q)
    for k in range(1, system.links + 1):
        axes.plot(points[:, k, 0], points[:, k, 1], color=ACCENT, linewidth=0.7)
    axes.plot(points[0, :, 0], points[0, :, 1], "-o", color=INK, markersize=3.5)
    axes.set(xlabel="$e_1$ (m)", ylabel="$e_2$ (m)", aspect="equal")


def _circle(axes: Any, found: Orbit) -> None:
    """Multipliers in the complex plane; what lies far out is drawn in its direction and said."""
    turn = np.linspace(0.0, 2 * np.pi, 200)
    axes.plot(np.cos(turn), np.sin(turn), color=SOFT, linewidth=0.9)
    lambdas = np.asarray(found.multipliers)
    size = np.abs(lambdas)
    shown = lambdas / np.where(size > 2, size / 2, 1.0)
    axes.plot(shown.real, shown.imag, "o", color=ACCENT if not found.is_stable else INK, markersize=5)
    for value, place in zip(lambdas[size > 2], shown[size > 2], strict=True):
        axes.annotate(f"{abs(value):.3g}", (place.real, place.imag), xytext=(0, 6), textcoords="offset points", fontsize=7, ha="center")
    axes.set(xlim=(-2.3, 2.3), ylim=(-2.3, 2.3), aspect="equal", xlabel="Re $\\lambda$", ylabel="Im $\\lambda$")
    axes.set_title("stable" if found.is_stable else "unstable")
