"""A climb along a family of orbits: the way of the chain beside the brakes of the family, its energy from rest to the top, the torque."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from phichain.report.style import ACCENT, INK, SOFT, figure, look, shades

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from phichain.laws import FamilyLaw
    from phichain.system import Vector

_SHOWN = 12
"""Orbits that are drawn."""


def climbing(law: FamilyLaw, t: Vector, x: Vector, u: Vector, energy: Vector) -> Figure:
    """One climb.

    Args:
        law: The law along the family.
        t: Times (m,), s.
        x: States (m, nx).
        u: Inputs (m, 1).
        energy: Energies (m,), J above the hanging chain.
    """
    half = x.shape[1] // 2
    with look():
        drawing = figure(9.6, 8.4)
        axes: Any = drawing.subplot_mosaic(
            [["plane", "family"], ["energy", "energy"], ["angles", "angles"], ["input", "input"]], height_ratios=[2.2, 1.0, 1.0, 0.7]
        )
        _orbits(axes["plane"], law, half)
        axes["family"].plot(law.energies[1:], 2 * np.pi / law.periods[1:], "o-", markersize=3, color=ACCENT)
        axes["family"].set(xlabel="energy (J)", ylabel=r"$\omega$ (rad/s)", title=f"the family, {len(law.energies) - 1} rungs of it", ylim=(0.0, None))
        axes["energy"].plot(t, energy, color=INK, linewidth=1.0)
        axes["energy"].axhline(law.energies[-1], color=SOFT, linewidth=0.8, linestyle="--")
        axes["energy"].set(ylabel="energy (J)")
        for k, colour in enumerate(shades(half)):
            axes["angles"].plot(t, x[:, k], color=colour, linewidth=0.8, label=law.catch.state_names[k])
        axes["angles"].set(ylabel="angles (rad)")
        axes["angles"].legend(loc="lower left", fontsize="small")
        axes["input"].plot(t, u[:, 0], color=ACCENT, linewidth=0.7)
        for side in (-law.limit, law.limit):
            axes["input"].axhline(side, color=SOFT, linewidth=0.8, linestyle="--")
        axes["input"].set(ylabel=f"{law.catch.input_names[0]} ({law.catch.input_units[0]})", xlabel="t (s)")
        for name in ("energy", "angles", "input"):
            axes[name].set_xlim(t[0], t[-1])
    return drawing


def _orbits(axes: Any, law: FamilyLaw, half: int) -> None:
    """Some orbits in the plane of the first and last angle, and their brakes."""
    last = half - 1
    for k in np.unique(np.linspace(1, len(law.states) - 1, _SHOWN).astype(int)):
        axes.plot(law.states[k, :, 0], law.states[k, :, last], color=SOFT, linewidth=0.9, zorder=1)
    axes.plot(law.states[1:, 0, 0], law.states[1:, 0, last], "o-", color=ACCENT, markersize=3, zorder=2)
    axes.plot(law.states[1:, -1, 0], law.states[1:, -1, last], "o-", color=ACCENT, markersize=3, zorder=2)
    names = law.catch.state_names
    axes.set(xlabel=f"{names[0]} (rad)", ylabel=f"{names[last]} (rad)", title=f"{law.name}: orbits from brake to brake")
