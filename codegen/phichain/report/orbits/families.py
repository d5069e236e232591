"""A family of orbits: frequency over amplitude and over energy, every event marked, numbered and named.

What is stable is drawn thick, what is not thin. Amplitudes beyond pi are left out, and said to be.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from phichain.continuation.problem import are_stable
from phichain.report.style import ACCENT, INK, SOFT, figure, look, shades

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from phichain.continuation import Branch, Special

Vector = NDArray[np.float64]

_MARKERS: Mapping[str, str] = {
    "fold": "o", "energy": "s", "brake": "^", "odd": "v", "unequal": "<", "cover": "*", "branch": "X", "krein": "D", "out": "P", "period": "p",
    "symmetry": "h", "phase": "H", "plane": "d", "reversal": "h", "momentum": "s", "no": "_",
}  # fmt: skip
"""Marks of the kinds of events, by the first word of their name."""
_ANGLES = ("conical", "whirling")
"""Methods whose orbits start with their links at angles that are no amplitudes."""
_LINES = 30
"""Events that a column of the list has room for."""


def family(branch: Branch) -> Figure:
    """One family: frequency over the amplitude of every link, over the energy where that is known, and its events listed beside."""
    events = branch.own_events
    has_energy = branch.energy is not None
    columns = -(-len(events) // _LINES)
    widths = [1.6] + [1.0] * has_energy + [0.85] * columns
    with look():
        drawing = figure(2.2 + 2.45 * sum(widths), 4.2)
        axes = np.atleast_1d(drawing.subplots(1, len(widths), width_ratios=widths))
        against_amplitude(axes[0], branch, events)
        if has_energy:
            axes[1].sharey(axes[0])
            against_energy(axes[1], branch, events)
            axes[1].set_ylabel("")
        for k in range(columns):
            _list(axes[1 + has_energy + k], branch, events, k)
    return drawing


def against_amplitude(axes: Any, branch: Branch, events: Sequence[Special] = ()) -> None:
    """Frequency over the angle of every link at the start, or its amplitude of one harmonic; a cart is left out. Over arclength where a start is no angles.

    Args:
        axes: Where to draw.
        branch: Unknowns amplitude_theta_1 .. amplitude_theta_N, or theta_1 .. theta_N, and omega.
        events: What to mark, numbered from 1.
    """
    omega = branch.column("omega")
    angles = [name for name in branch.names if name.startswith(("amplitude_theta", "theta")) and "dot" not in name]
    thick = _stable(branch)
    if not angles:
        _against_arclength(axes, branch, events)
        return
    beyond = []
    letter = r"\theta" if branch.method in _ANGLES else "A"
    for name, colour in zip(angles, shades(len(angles)), strict=True):
        link, column = name.rpartition("_")[2], branch.names.index(name)
        # Beyond pi an angle says no longer where its link is.
        amplitude = np.where(np.abs(branch.column(name)) <= np.pi, branch.column(name), np.nan)
        if np.any(np.isnan(amplitude)):
            beyond.append(link)
        axes.plot(amplitude, omega, color=colour, linewidth=0.9, label=f"${letter}_{{{link}}}$")
        if thick is not None:
            axes.plot(np.where(thick, amplitude, np.nan), np.where(thick, omega, np.nan), color=colour, linewidth=2.4)
        for event in events:
            if abs(event.z[column]) <= np.pi:
                _mark(axes, event, event.z[column], colour)
    _numbers(axes, branch, events, angles)
    axes.axhline(omega[0], color=SOFT, linewidth=0.8, linestyle=":", label="where it starts")
    label = "angle from the vertical (rad)" if branch.method in _ANGLES else "amplitude (rad)"
    if beyond:
        label += f"; not drawn beyond $\\pi$: link {', '.join(beyond)}"
    axes.set(xlabel=label, ylabel=r"$\omega$ (rad/s)")
    place = {"loc": "lower left", "bbox_to_anchor": (0.0, 1.0), "borderaxespad": 0.2}
    axes.legend(ncols=len(angles) + 1, handlelength=1.0, columnspacing=1.0, **place)


def _against_arclength(axes: Any, branch: Branch, events: Sequence[Special]) -> None:
    """Frequency along a family whose orbits are taken up while they move."""
    omega, thick = branch.column("omega"), _stable(branch)
    axes.plot(branch.arclength, omega, color=ACCENT, linewidth=0.9)
    if thick is not None:
        axes.plot(branch.arclength, np.where(thick, omega, np.nan), color=ACCENT, linewidth=2.4)
    for event in events:
        _mark(axes, event, event.arclength, ACCENT)
    numbered(axes, [(event.arclength, float(event.z[-1])) for event in events])
    axes.set(xlabel="arclength", ylabel=r"$\omega$ (rad/s)")


def against_energy(axes: Any, branch: Branch, events: Sequence[Special] = (), *, colour: Any = ACCENT) -> None:
    """Frequency over the orbit's energy, counted from the hanging rest."""
    omega, thick = branch.column("omega"), _stable(branch)
    energy: Any = branch.energy
    axes.plot(energy, omega, color=colour, linewidth=0.9)
    if thick is not None:
        axes.plot(np.where(thick, energy, np.nan), np.where(thick, omega, np.nan), color=colour, linewidth=2.4)
    places = [(energy_at(branch, event), float(event.z[-1])) for event in events]
    for event, (across, _) in zip(events, places, strict=True):
        _mark(axes, event, across, colour)
    numbered(axes, places)
    axes.set(xlabel="energy (J)", ylabel=r"$\omega$ (rad/s)")


def energy_at(branch: Branch, event: Special) -> float:
    """Energy of an event, J, by the cubic through the points beside it: dE/ds there by differences."""
    energy: Any = branch.energy
    k = min(event.index, len(branch) - 2)
    slope = np.gradient(energy, branch.arclength)
    low, high = branch.arclength[k], branch.arclength[k + 1]
    share, length = (event.arclength - low) / (high - low), high - low
    rest = 1 - share
    ends = energy[k] * (rest**2 * (1 + 2 * share)) + energy[k + 1] * (share**2 * (1 + 2 * rest))
    return float(ends + length * share * rest * (rest * slope[k] - share * slope[k + 1]))


def _stable(branch: Branch) -> NDArray[np.bool_] | None:
    """Which points are stable; None where the method does not say."""
    several = sum(name.startswith("theta") for name in branch.names) > 1
    if branch.method == "one harmonic" or not branch.method or (several and not branch.multipliers.shape[1]):
        return None
    return are_stable(branch.multipliers)


def marker_of(kind: str) -> str:
    """The mark of a kind of events."""
    return _MARKERS.get(kind.split()[0], "o")


def _mark(axes: Any, event: Special, across: float, colour: Any) -> None:
    marker = marker_of(event.kind)
    size = 8.0 if marker == "*" else 4.5
    axes.plot(across, event.z[-1], marker, color=colour, markerfacecolor="white", markersize=size, zorder=5)


def _numbers(axes: Any, branch: Branch, events: Sequence[Special], angles: Sequence[str]) -> None:
    """Every event's number beside its mark on the link that swings furthest."""
    columns = [branch.names.index(name) for name in angles]
    numbered(axes, [(max((float(event.z[k]) for k in columns if abs(event.z[k]) <= np.pi), key=abs, default=np.nan), float(event.z[-1]))
                  for event in events])  # fmt: skip


def numbered(axes: Any, places: Sequence[tuple[float, float]]) -> None:
    """Numbers from 1 at places; those that lie on one another are written as one."""
    if not places:
        return
    x, y = np.array(places).T
    span = np.array([np.ptp(axes.get_xlim()), np.ptp(axes.get_ylim())])
    groups: list[list[int]] = []
    for k in range(len(places)):
        near = [g for g in groups if np.hypot((x[k] - x[g[0]]) / span[0], (y[k] - y[g[0]]) / span[1]) < 0.02]
        (near[0] if near else groups.append([]) or groups[-1]).append(k)  # type: ignore[func-returns-value]
    for group in groups:
        at = group[0]
        if np.isfinite(x[at]):
            words = ",".join(str(k + 1) for k in group)
            axes.annotate(words, (x[at], y[at]), xytext=(4, 3), textcoords="offset points", fontsize=6.5, color=INK)


def _list(axes: Any, branch: Branch, events: Sequence[Special], column: int) -> None:
    """The events by number: kind, frequency and energy."""
    axes.set_axis_off()
    shown = list(enumerate(events, 1))[column * _LINES : (column + 1) * _LINES]
    for line, (number, event) in enumerate(shown):
        energy = "" if branch.energy is None else f", {energy_at(branch, event):.4g} J"
        text = f"{number}  {event.kind}: {event.z[-1]:.6g} rad/s{energy}"
        axes.text(0.0, 1.0 - line / _LINES, text, fontsize=6.5, va="top", transform=axes.transAxes)
