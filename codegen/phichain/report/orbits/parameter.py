"""A run in a parameter of the chain: frequency, start and energy over it, every event marked, numbered and named."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from phichain.continuation.problem import are_stable
from phichain.report.orbits.families import marker_of, numbered
from phichain.report.style import ACCENT, INK, figure, look, shades

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from phichain.continuation import Branch

_LINES: Final = 24
"""Events that the list has room for."""
_ON_CIRCLE: Final = 1 + 1e-9


def in_parameter(branch: Branch) -> Figure:
    """Over the parameter: omega, the angles of the start where it has some, and the energy where that is known; events listed beside.

    What is stable is drawn thick; of a held event, at which stability is just lost, nothing is.
    """
    events = branch.own_events
    angles = [k for k, name in enumerate(branch.names[:-1]) if name.startswith("theta") and "dot" not in name]
    panels = 1 + bool(angles) + (branch.energy is not None)
    with look():
        drawing = figure(1.6 + 2.9 * panels + 2.2 * bool(events), 3.6)
        axes = np.atleast_1d(drawing.subplots(1, panels + bool(events), width_ratios=[1.0] * panels + [0.9] * bool(events)))
        frequency(axes[0], branch)
        if angles:
            _angles(axes[1], branch, angles)
        if branch.energy is not None:
            axes[panels - 1].plot(branch.points[:, -1], branch.energy, color=ACCENT)
            axes[panels - 1].set(xlabel=branch.names[-1], ylabel="energy (J)")
        if events:
            _list(axes[panels], branch)
        drawing.suptitle(branch.name, fontsize=8)
    return drawing


def frequency(axes: Any, branch: Branch) -> None:
    """omega over the parameter."""
    at, turned = branch.names.index("omega"), branch.points[:, -1]
    omega, thick = branch.points[:, at], _stable(branch)
    axes.plot(turned, omega, color=ACCENT, linewidth=0.9)
    if thick is not None:
        axes.plot(turned, np.where(thick, omega, np.nan), color=ACCENT, linewidth=2.4)
    for event in branch.own_events:
        axes.plot(event.z[-1], event.z[at], marker_of(event.kind), color=ACCENT, markerfacecolor="white", markersize=4.5, zorder=5)
    numbered(axes, [(float(event.z[-1]), float(event.z[at])) for event in branch.own_events])
    axes.set(xlabel=branch.names[-1], ylabel=r"$\omega$ (rad/s)")


def _angles(axes: Any, branch: Branch, angles: list[int]) -> None:
    for k, colour in zip(angles, shades(len(angles)), strict=True):
        # Beyond pi an angle says no longer where its link is.
        angle = np.where(np.abs(branch.points[:, k]) <= np.pi, branch.points[:, k], np.nan)
        axes.plot(branch.points[:, -1], angle, color=colour, label=branch.names[k])
    axes.set(xlabel=branch.names[-1], ylabel="angle at the start (rad)")
    axes.legend()


def _stable(branch: Branch) -> NDArray[np.bool_] | None:
    """Which points are stable; None where an event is held, or the method does not say."""
    if " = " not in branch.closing or not branch.multipliers.shape[1]:
        return None
    if branch.method.startswith("forced"):
        return np.asarray(np.max(np.abs(branch.multipliers), axis=1) <= _ON_CIRCLE)
    return are_stable(branch.multipliers)


def _list(axes: Any, branch: Branch) -> None:
    """The events by number: kind, parameter and frequency."""
    axes.set_axis_off()
    at = branch.names.index("omega")
    for line, event in enumerate(branch.own_events[:_LINES]):
        text = f"{line + 1}  {event.kind}: {branch.names[-1]} = {event.z[-1]:.6g}, {event.z[at]:.6g} rad/s"
        axes.text(0.0, 1.0 - line / _LINES, text, fontsize=6.5, va="top", color=INK, transform=axes.transAxes)
    if (more := len(branch.own_events) - _LINES) > 0:
        axes.text(0.0, 0.0, f"and {more} more", fontsize=6.5, color=INK, transform=axes.transAxes)
