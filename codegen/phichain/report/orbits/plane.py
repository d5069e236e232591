"""Several families in one picture: frequency over energy, how they hang together, and conical families."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from phichain.continuation.problem import are_stable
from phichain.report.orbits.families import energy_at, marker_of
from phichain.report.style import ACCENT, INK, SOFT, figure, look

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from phichain.continuation import Branch
    from phichain.orbits import Network

_COLOURS = ("#1b4f72", "#c2410c", "#1e8449", "#7d3c98", "#b7950b", "#5d6d7e", "#a93226", "#117a65")


def energies(branches: Sequence[Branch], title: str) -> Figure:
    """Frequency over energy of the families of all modes, both logarithmic; every event marked by its kind, covers and gaps named."""
    with look():
        drawing = figure(9.6, 5.4)
        axes = drawing.subplots()
        covers: list[Any] = []
        gaps: dict[str, Any] = {}
        for branch, colour in zip(branches, _colours(len(branches)), strict=True):
            _curve(axes, branch, colour, f"mode {branch.mode}")
            for event in branch.own_events:
                covers += _mark(axes, branch, event, colour, words=event.kind.removeprefix("cover ") if event.kind.startswith("cover") else "")
            for gap in branch.passages:
                place = float(np.interp(gap.arclength, branch.arclength, np.asarray(branch.energy))), float(gap.z[-1])
                words = f"gap {gap.width:.1e}{' crossed' if gap.is_crossed else ''}"
                # A run that turns in a gap meets it twice.
                if words not in gaps:
                    gaps[words] = _label(axes, words, place, (-60, -24), colour)
        axes.set(xscale="log", yscale="log", xlabel="energy (J)", ylabel=r"$\omega$ (rad/s)", title=title)
        axes.yaxis.set_minor_formatter("{x:g}")
        axes.tick_params(axis="y", which="minor", labelsize=7)
        _kinds(axes, [event.kind for branch in branches for event in branch.own_events], loc="upper left", bbox_to_anchor=(1.0, 1.0))
        axes.set_ylim(bottom=axes.get_ylim()[0] * (0.75 if gaps else 1.0))
        set_apart(drawing, covers, 1)
        set_apart(drawing, sorted(gaps.values(), key=lambda label: -label.xy[0]), -1)
    return drawing


def network(found: Network) -> Figure:
    """Branches over energy, numbered where they end, and where each hangs on another."""
    with look():
        drawing = figure(8.8, 5.6)
        axes = drawing.subplots()
        colours = _colours(len(found.branches))
        for k, (branch, colour) in enumerate(zip(found.branches, colours, strict=True)):
            _curve(axes, branch, colour, f"[{k}] {branch.name.split(', ')[1]}: {branch.closing or 'quarter'}")
            for event in branch.own_events:
                _mark(axes, branch, event, colour)
        named = [
            _label(axes, ", ".join(words), place, (10, 20 if k % 2 == 0 else -24), INK) for k, (place, words) in enumerate(_hangings(found).items())
        ]
        axes.set(yscale="log", xlabel="energy (J)", ylabel=r"$\omega$ (rad/s)", title=found.name)
        axes.yaxis.set_minor_formatter("{x:g}")
        axes.tick_params(axis="y", which="minor", labelsize=7)
        axes.legend(loc="upper right", fontsize=7)
        set_apart(drawing, named[::2], 1)
        set_apart(drawing, named[1::2], -1)
    return drawing


def _label(axes: Any, words: str, place: tuple[float, float], away: tuple[float, float], colour: str) -> Any:
    """Words beside a place, with a line to it."""
    line = {"arrowstyle": "-", "color": SOFT, "linewidth": 0.6, "shrinkA": 0.0}
    return axes.annotate(words, place, xytext=away, textcoords="offset points", fontsize=6.5, color=colour, arrowprops=line)


def set_apart(drawing: Figure, labels: Sequence[Any], way: int) -> None:
    """Move labels that lie on one another up (1) or down (-1), line by line, until none does."""
    from matplotlib.text import Text

    drawing.draw_without_rendering()
    placed: list[Any] = []
    for label in labels:
        for _ in range(4 * len(labels)):
            box = Text.get_window_extent(label).padded(1.0)
            if not any(box.overlaps(other) for other in placed):
                break
            across, up = label.xyann
            label.xyann = (across, up + 2.0 * way)
        placed.append(box)


def _hangings(found: Network) -> dict[tuple[float, float], list[str]]:
    """What hangs on what, in words, by where it is to be written; what lies on one another is written together."""
    words: dict[tuple[float, float], list[str]] = {}
    for link in (link for link in found.links if link.to >= 0):
        branch = found.branches[link.branch]
        event = branch.events[link.event]
        place = energy_at(branch, event), float(event.z[-1])
        near = [at for at in words if np.allclose(at, place, rtol=2e-2, atol=0.05)]
        said = words.setdefault(near[0] if near else place, [])
        said += [text for text in [f"{link.how} [{link.to}]"] if text not in said]
    return words


def gap(turned: Branch, crossed: Branch, reach: float = 30.0) -> Figure:
    """An avoided crossing: the run that turns with its branch and the run that goes on beyond, the first angle over the last, in widths.

    Args:
        turned: A run whose first passage is the gap, followed.
        crossed: One that crossed it.
        reach: Half the side of the picture, in half widths of the gap.
    """
    passage = turned.passages[0]
    links = [k for k, name in enumerate(turned.names) if name.startswith("theta")]
    first, last = links[0], links[-1]
    with look():
        drawing = figure(6.6, 4.4)
        axes = drawing.subplots()
        for branch, colour, words in ((crossed, _COLOURS[1], "crossed on request"), (turned, _COLOURS[0], "followed: the branch turns")):
            off = (branch.points[:, [first, last]] - passage.z[[first, last]]) / passage.width
            axes.plot(off[:, 0], off[:, 1], "-o", color=colour, markersize=3, linewidth=1.0, label=words)
        axes.plot(0.0, 0.0, "D", color=INK, markersize=5, label=f"the gap, half width {passage.width:.2g}")
        axes.set(
            xlim=(-reach, reach), ylim=(-reach, reach), xlabel=rf"$\theta_1$ - {passage.z[first]:.6f}, in half widths",
            ylabel=rf"$\theta_{len(links)}$ - {passage.z[last]:.6f}, in half widths",
        )  # fmt: skip
        axes.legend(loc="best")
    return drawing


def conical(branches: Sequence[Branch]) -> Figure:
    """Conical families: the angles of the first and the last link, and energy over angular momentum."""
    with look():
        drawing = figure(10.0, 4.8)
        left, right = drawing.subplots(1, 2)
        for branch, colour in zip(branches, _colours(len(branches)), strict=True):
            momentum: Any = branch.momentum
            energy: Any = branch.energy
            angles = [branch.column(name) for name in branch.names if name.startswith("theta")]
            thick = are_stable(branch.multipliers)
            name = branch.name.partition(", ")[2]
            for axes, across, up in ((left, angles[0], angles[-1]), (right, momentum, energy)):
                axes.plot(across, up, color=colour, linewidth=0.9, label=name if axes is right else None)
                axes.plot(np.where(thick, across, np.nan), np.where(thick, up, np.nan), color=colour, linewidth=2.6)
            for event in branch.own_events:
                across = float(np.interp(event.arclength, branch.arclength, momentum))
                columns = [k for k, name in enumerate(branch.names) if name.startswith("theta")]
                for axes, place in ((left, (event.z[columns[0]], event.z[columns[-1]])), (right, (across, energy_at(branch, event)))):
                    axes.plot(*place, marker_of(event.kind), color=colour, markerfacecolor="white", markersize=5, zorder=5)
        last = len(angles)
        left.set(xlabel=r"$\theta_1$ from the vertical (rad)", ylabel=rf"$\theta_{last}$ (rad)")
        right.set(xlabel="angular momentum (kg m$^2$/s)", ylabel="energy (J)", xscale="log", yscale="log")
        right.legend(loc="lower right", fontsize=7)
        left.set_title("thick: stable")
        _kinds(left, [event.kind for branch in branches for event in branch.own_events], loc="best")
    return drawing


def _colours(count: int) -> list[str]:
    return [_COLOURS[k % len(_COLOURS)] for k in range(count)]


def _curve(axes: Any, branch: Branch, colour: str, name: str) -> None:
    energy, omega = np.asarray(branch.energy), branch.column("omega")
    thick = are_stable(branch.multipliers)
    axes.plot(energy, omega, color=colour, linewidth=0.8, label=name)
    axes.plot(np.where(thick, energy, np.nan), np.where(thick, omega, np.nan), color=colour, linewidth=2.3)


def _mark(axes: Any, branch: Branch, event: Any, colour: str, words: str = "") -> list[Any]:
    """Mark an event; its label, where it is given words."""
    place = energy_at(branch, event), float(event.z[-1])
    axes.plot(*place, marker_of(event.kind), color=colour, markerfacecolor="white", markersize=7 if words else 3.6, zorder=5)
    return [axes.annotate(words, place, xytext=(5, 4), textcoords="offset points", fontsize=6.5, color=INK)] if words else []


def _kinds(axes: Any, kinds: Sequence[str], **place: Any) -> None:
    """What lines and marks mean, those that there are, in a legend at a place."""
    seen = dict.fromkeys(kind.split(" of ")[0].rstrip("0123456789 ") for kind in kinds)
    for kind in seen:
        axes.plot([], [], marker_of(kind), color=ACCENT, markerfacecolor="white", markersize=4.5, label=kind)
    if axes.get_legend_handles_labels()[0]:
        axes.legend(fontsize=7, **place)
