"""What figures of chains are made of: links, masses, joints, bases, arrows, words."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from typing import Any, Final

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Arc, Circle, FancyArrowPatch, FancyBboxPatch, Rectangle

from phichain.report.style import ACCENT, INK, SOFT

Place = tuple[float, float]

BLUE: Final = "#1d4ed8"
"""What goes from the base to the tip."""
GREEN: Final = "#15803d"
"""What is kept of a link."""
PALE: Final = "#f3f5f8"
LINK: Final = "#c3cad4"
__all__ = [
    "ACCENT", "BLUE", "GREEN", "INK", "LINK", "PALE", "SOFT", "angle", "arrow", "box", "canvas", "cart", "chain", "chart", "frame",
    "joint", "link", "mass", "panel", "places", "sphere", "spring", "steps", "turned", "wall", "words",
]  # fmt: skip


def canvas(width: float, height: float, *parts: tuple[float, float, float, float]) -> tuple[Figure, list[Axes]]:
    """A figure (inches) and empty drawing areas in it, each (left, bottom, width, height) in parts of the whole."""
    figure = Figure(figsize=(width, height))
    areas = [figure.add_axes(part) for part in parts or ((0.0, 0.0, 1.0, 1.0),)]
    for area in areas:
        area.set_axis_off()
    return figure, areas


def frame(ax: Axes, x: Place, y: Place) -> None:
    """Say which part of the plane an area shows, in equal scales; heights count upwards."""
    ax.set_xlim(*x)
    ax.set_ylim(*y)
    ax.set_aspect("equal")


def panel(figure: Figure, part: tuple[float, float, float, float], x: str, y: str) -> Axes:
    """An area with axes, for curves."""
    ax = figure.add_axes(part)
    ax.set_xlabel(x)
    ax.set_ylabel(y)
    ax.grid(color="#e3e7ec", linewidth=0.7)
    ax.set_axisbelow(True)
    return ax


def words(ax: Axes, at: Place, text: str, **style: Any) -> None:
    """Words at a place, in its middle unless said otherwise."""
    ax.text(*at, text, **{"ha": "center", "va": "center", "color": INK, "linespacing": 1.35} | style)


def arrow(ax: Axes, start: Place, end: Place, text: str = "", *, color: str = INK, off: Place = (0.0, 0.0), **style: Any) -> None:
    """An arrow, and words off its middle."""
    look = {"arrowstyle": "-|>", "mutation_scale": 10.0, "shrinkA": 0.0, "shrinkB": 0.0, "linewidth": 1.3, "color": color, "zorder": 4}
    size = style.pop("fontsize", 9.0)
    ax.add_patch(FancyArrowPatch(start, end, **look | style))
    if text:
        middle = (start[0] + end[0]) / 2 + off[0], (start[1] + end[1]) / 2 + off[1]
        words(ax, middle, text, color=color, fontsize=size)


def box(ax: Axes, at: Place, size: Place, text: str, *, color: str = INK, fill: str = PALE, **style: Any) -> None:
    """Words in a box whose middle is at a place."""
    width, height = size
    corner = at[0] - width / 2, at[1] - height / 2
    ax.add_patch(FancyBboxPatch(corner, width, height, boxstyle="round,pad=0,rounding_size=0.12", facecolor=fill, edgecolor=color, linewidth=1.0, zorder=2))
    words(ax, at, text, zorder=3, **style)


def turned(angle_from_down: float) -> Place:
    """The unit vector (sin, -cos) of a link that leans by an angle from hanging."""
    return math.sin(angle_from_down), -math.cos(angle_from_down)


def places(start: Place, angles: Sequence[float], lengths: Sequence[float]) -> list[Place]:
    """The joints of a chain from its base to its tip; angles are absolute, in rad."""
    found = [start]
    for lean, length in zip(angles, lengths, strict=True):
        x, y = turned(lean)
        found.append((found[-1][0] + length * x, found[-1][1] + length * y))
    return found


def link(ax: Axes, start: Place, end: Place, *, color: str = LINK, width: float = 7.0) -> None:
    """A link, as a bar with round ends."""
    ax.plot([start[0], end[0]], [start[1], end[1]], color=color, linewidth=width, zorder=1)


def mass(ax: Axes, at: Place, radius: float = 0.09, color: str = INK) -> None:
    """A point mass."""
    ax.add_patch(Circle(at, radius, facecolor=color, edgecolor=color, zorder=3))


def joint(ax: Axes, at: Place, radius: float = 0.07) -> None:
    """A joint."""
    ax.add_patch(Circle(at, radius, facecolor="white", edgecolor=INK, linewidth=1.2, zorder=3))


def wall(ax: Axes, at: Place, width: float = 0.8) -> None:
    """A fixed base above a place."""
    left, y = at[0] - width / 2, at[1]
    ax.plot([left, left + width], [y, y], color=INK, linewidth=1.4, zorder=2)
    for k in range(7):
        x = left + (k + 0.5) * width / 7
        ax.plot([x, x + 0.1], [y, y + 0.13], color=INK, linewidth=0.8)


def cart(ax: Axes, at: Place, size: Place = (0.9, 0.34)) -> None:
    """A cart on its track, its joint at a place."""
    width, height = size
    ax.add_patch(Rectangle((at[0] - width / 2, at[1] - height / 2), width, height, facecolor=PALE, edgecolor=INK, linewidth=1.2, zorder=1))
    for side in (-0.28, 0.28):
        ax.add_patch(Circle((at[0] + side * width, at[1] - height / 2 - 0.09), 0.09, facecolor="white", edgecolor=INK, linewidth=1.2, zorder=2))
    ground = at[1] - height / 2 - 0.18
    for left, right in ((-1.0, -0.2), (0.2, 1.0)):
        ax.plot([at[0] + left * width, at[0] + right * width], [ground, ground], color=SOFT, linewidth=1.0)


def chain(ax: Axes, joints: Sequence[Place], at: float = 1.0, *, base: str = "wall") -> list[Place]:
    """A chain with its masses at a part of each link; returns where these are."""
    {"wall": wall, "cart": cart, "none": lambda *_: None}[base](ax, joints[0])
    masses = []
    for start, end in itertools.pairwise(joints):
        link(ax, start, end)
        masses.append((start[0] + at * (end[0] - start[0]), start[1] + at * (end[1] - start[1])))
    for place in joints[:-1]:
        joint(ax, place)
    for place in masses:
        mass(ax, place)
    return masses


def angle(ax: Axes, centre: Place, radius: float, start: float, end: float, text: str = "", *, color: str = INK, away: float = 0.2) -> None:
    """An angle between two leans from hanging (rad), with its name in its middle."""
    first, last = sorted((math.degrees(start) - 90, math.degrees(end) - 90))
    ax.add_patch(Arc(centre, 2 * radius, 2 * radius, theta1=first, theta2=last, color=color, linewidth=1.1, zorder=2))
    if text:
        x, y = turned((start + end) / 2)
        words(ax, (centre[0] + (radius + away) * x, centre[1] + (radius + away) * y), text, color=color)


def sphere(ax: Axes, centre: Place, radius: float) -> None:
    """A sphere with its equator."""
    ax.add_patch(Circle(centre, radius, facecolor=PALE, edgecolor=SOFT, linewidth=1.0, zorder=0))
    ax.add_patch(Arc(centre, 2 * radius, 0.6 * radius, theta1=180, theta2=360, color=SOFT, linewidth=0.8))
    ax.add_patch(Arc(centre, 2 * radius, 0.6 * radius, theta1=0, theta2=180, color=SOFT, linewidth=0.6, linestyle=(0, (3, 3))))


def chart(ax: Axes, corners: Sequence[Place], color: str = "#e2e9fb") -> None:
    """A plane, seen from the side."""
    ax.fill([x for x, _ in corners], [y for _, y in corners], color=color, alpha=0.8, zorder=1, linewidth=0.0)


def steps(ax: Axes, middles: Sequence[Place], size: Place, texts: Sequence[str], colors: Sequence[str]) -> None:
    """Boxes in a row, each with an arrow to the next one."""
    for at, text, color in zip(middles, texts, colors, strict=True):
        box(ax, at, size, text, color=color, fontsize=8.5)
    for left, right in itertools.pairwise(middles):
        arrow(ax, (left[0] + size[0] / 2, left[1]), (right[0] - size[0] / 2, right[1]), color=SOFT)


def spring(ax: Axes, centre: Place, radius: float, start: float, end: float, color: str = INK) -> None:
    """A spiral spring about a joint between two leans (rad)."""
    points = [(start + (end - start) * k / 40, radius * (1 + 0.1 * (1 if k % 4 in (1, 2) else -1))) for k in range(41)]
    xy = [(centre[0] + r * turned(lean)[0], centre[1] + r * turned(lean)[1]) for lean, r in points]
    ax.plot([x for x, _ in xy], [y for _, y in xy], color=color, linewidth=1.0, zorder=2)
