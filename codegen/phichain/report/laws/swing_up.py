"""The strip of a swing-up: the chain moment by moment, the cart's place, the inputs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from phichain.report.geometry import Drawn, joints, tilt
from phichain.report.panels import against_time
from phichain.report.style import ACCENT, INK, SOFT, figure, look, shades

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from phichain.control.swing_up import Plan

_MOMENTS = 17
_UNITS = {"force": "N", "torque": "N m", "acceleration": "m/s$^2$"}


def strip(system: Drawn, plan: Plan) -> Figure:
    """A planned motion as a strip of pictures over time, with angles, the cart's place and inputs below.

    Args:
        system: The chain.
        plan: The motion.
    """
    rows = ["chain", "angles", *(["cart"] if system.has_cart else []), "input"]
    heights = {"chain": 2.0, "angles": 1.2, "cart": 0.9, "input": 0.9}
    with look():
        drawing = figure(9.6, 1.7 * len(rows) + 0.6)
        axes: Any = drawing.subplot_mosaic([[row] for row in rows], height_ratios=[heights[row] for row in rows])
        _pictures(axes["chain"], system, plan)
        axes["chain"].set_title(f"{plan.name}, planned in {plan.duration:.3g} s")
        q = plan.x[:, : system.nq]
        against_time(axes["angles"], plan.t, tilt(system, q), [f"link {k}" for k in range(1, system.links + 1)], "link angle (rad)")
        if system.has_cart:
            axes["cart"].plot(plan.t, plan.x[:, 0], color=INK)
            axes["cart"].set(ylabel="cart (m)", xlim=(0.0, plan.duration))
            if plan.rail:
                _bounds(axes["cart"], plan.rail)
        for k, colour in enumerate(shades(plan.u.shape[1]) if plan.u.shape[1] > 1 else [ACCENT]):
            axes["input"].step(plan.t[:-1], plan.u[:, k], where="post", color=colour)
        _bounds(axes["input"], float(np.max(plan.limit)))
        axes["input"].set(ylabel=" and ".join(f"{name} ({_UNITS.get(name.partition('_')[0], '')})" for name in plan.input_names), xlabel="t (s)", xlim=(0.0, plan.duration))
    return drawing


def _bounds(axes: Any, size: float) -> None:
    for side in (-size, size):
        axes.axhline(side, color=SOFT, linewidth=0.8, linestyle="--")


def _pictures(axes: Any, system: Drawn, plan: Plan) -> None:
    """The chain at even times, each picture about its own moment, lengths to one scale, the base at its own height."""
    reach = float(np.sum(system.number("length")))
    scale = 0.75 * plan.duration / (_MOMENTS - 1) / reach
    for at in np.linspace(0, len(plan.t) - 1, _MOMENTS).astype(int):
        points = joints(system, plan.x[at, : system.nq])
        across = plan.t[at] + scale * (points[:, 0] - points[0, 0])
        axes.plot(across, -points[:, 1], color=SOFT, linewidth=1.0, zorder=1)
        axes.scatter(across[1:], -points[1:, 1], s=14, c=shades(system.links), zorder=2)
        axes.plot(plan.t[at], 0.0, marker="s", markersize=5, color=INK, zorder=3)
    margin = 0.75 * plan.duration / (_MOMENTS - 1)
    axes.set(ylim=(-1.1 * reach, 1.1 * reach), xlim=(-margin, plan.duration + margin), ylabel="height (m)", xlabel="")
    axes.axhline(0.0, color=SOFT, linewidth=0.8, zorder=0)
