"""Signal propagation as figures: the surfaces of paper A's Figs 3 to 6, and the paths through N and G.

A signal goes from the forces u (p = 0) to the accelerations theta'' (p = 1 and alpha = 0) and on to the angles theta
(alpha = -2). Its size changes on the way by several orders of magnitude, and its unit with it. So every surface is
drawn twice: over a height that is linear near zero and logarithmic beyond (asinh), which shows the sizes, and as a map
in which every order is divided by its own size, which shows the shape.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from phichain.records import Held
from phichain.report.style import ACCENT, INK, SOFT, figure, look

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from phichain.fractional import Propagation

Vector = NDArray[np.float64]

SETTLED = 0.05
"""The share of the time left out when sizes are taken: psi with initial terms is unbounded at t = 0."""

PATH_NAMES: Mapping[str, str] = {
    "coriolis": "through $N$",
    "gravity": "through $G$",
    "feedback": "through $N$ and $G$",
    "input": "from $T$",
    "joints": "through springs and dampers",
    "total": "all",
}
_HEADS = (
    r"$\theta_p = (I^{-1})^p u$: black $u$, red $\ddot\theta$",
    r"$\psi = D^\alpha \ddot\theta$: black $\theta$, red $\ddot\theta$",
    "both, every order over its own size (right)",
)
_HEIGHTS = "heights in SI units, linear near zero and logarithmic beyond"
_WHOLE = ("$u$", r"$\ddot\theta$", r"$\dot\theta$", r"$\theta$")
_BARE = ("$u$", r"$\ddot\theta$", r"$D^{-1}$", r"$D^{-2}$")
_HUES = "RdBu_r"
_SEEN = 320


@dataclass(frozen=True, eq=False)
class Wave(Held):
    """One signal of one coordinate from force to angle.

    Attributes:
        time: Times (m,), s.
        p: Powers (P,), rising.
        alpha: Orders (A,), rising to 0.
        theta_p: Surface (m, P).
        psi: Surface (m, A).
    """

    time: Vector
    p: Vector
    alpha: Vector
    theta_p: Vector
    psi: Vector

    @classmethod
    def of(cls, result: Propagation, coordinate: int, path: str = "total") -> Wave:
        """The wave of one coordinate along one path, thinned to what a picture can show."""
        step = max(1, (result.time.size - 1) // _SEEN)
        surfaces = (result.surface(kind, coordinate, path)[::step] for kind in ("theta_p", "psi"))
        return cls(result.time[::step], result.p, result.alpha, *surfaces)

    @property
    def sizes(self) -> tuple[Vector, Vector]:
        """Largest modulus of every order over the settled time: (P,) and (A,)."""
        return size_of_orders(self.time, self.theta_p), size_of_orders(self.time, self.psi)


def size_of_orders(time: Vector, surface: Vector) -> Vector:
    """Largest modulus of every column of a surface (m, K), the first twentieth of the time left out; shape (K,)."""
    settled = time >= time[0] + SETTLED * (time[-1] - time[0])
    sizes: Vector = np.nanmax(np.abs(surface[settled]), axis=0)
    return np.where(sizes > 0, sizes, 1.0)


def surfaces(result: Propagation, title: str, coordinates: int | None = None) -> Figure:
    """The whole signal of coordinates: two surfaces, the map of both, and the size of every order.

    Args:
        result: The signals.
        title: What is shown.
        coordinates: How many, from the base on; all unless given.
    """
    names = row_names(result)[:coordinates]
    rows = len(names)
    with look():
        drawing = figure(11.0, 0.9 + 2.45 * rows)
        drawing.set_layout_engine("none")
        height = drawing.get_figheight()
        grid = drawing.add_gridspec(
            rows, 3, left=0.0, right=0.985, top=1 - 0.72 / height, bottom=0.5 / height, wspace=0.06, hspace=0.2,
            width_ratios=(1.0, 1.0, 1.25),
        )  # fmt: skip
        drawing.text(0.012, 1 - 0.3 / height, title, fontsize=11, va="center")
        for row, name in enumerate(names):
            wave = Wave.of(result, row)
            left = drawing.add_subplot(grid[row, 0], projection="3d")
            _surface(left, wave.time, wave.p, wave.theta_p, "p")
            left.text2D(0.02, 0.95, name, transform=left.transAxes, fontsize=10)
            _surface(
                drawing.add_subplot(grid[row, 1], projection="3d"),
                wave.time,
                wave.alpha,
                wave.psi,
                r"$\alpha$",
            )
            inner = grid[row, 2].subgridspec(
                2, 2, height_ratios=(1, 2), width_ratios=(1, 0.22), hspace=0.0, wspace=0.06
            )
            cells = [[drawing.add_subplot(inner[r, c]) for c in range(2)] for r in range(2)]
            _wave(cells, wave, last=row == rows - 1)
        for across, words in zip((0.155, 0.455, 0.78), _HEADS, strict=True):
            drawing.text(across, 1 - 0.6 / height, words, ha="center", color=SOFT, fontsize=9)
        drawing.text(0.012, 0.05 / height, _HEIGHTS, color=SOFT, fontsize=8)
    return drawing


def paths(result: Propagation, title: str) -> Figure:
    """Every part of the signal by itself: maps in one common scale per order, so that the parts add up by eye."""
    parts = [path for path in result.forces if path != "total"]
    rows = len(result.coordinates)
    with look():
        drawing = figure(1.3 + 3.1 * len(parts), 0.8 + 2.3 * rows)
        drawing.set_layout_engine("none")
        width, height = drawing.get_figwidth(), drawing.get_figheight()
        grid = drawing.add_gridspec(
            rows, len(parts), left=0.75 / width, right=1 - 0.15 / width, top=1 - 0.72 / height, bottom=0.5 / height,
            wspace=0.06, hspace=0.14,
        )  # fmt: skip
        drawing.text(0.13 / width, 1 - 0.25 / height, title, fontsize=11, va="center")
        for row, name in enumerate(row_names(result)):
            waves = {path: Wave.of(result, row, path) for path in parts}
            common = [np.max([wave.sizes[k] for wave in waves.values()], axis=0) for k in range(2)]
            for column, (path, wave) in enumerate(waves.items()):
                inner = grid[row, column].subgridspec(2, 1, height_ratios=(1, 2), hspace=0.0)
                cells = [drawing.add_subplot(inner[r]) for r in range(2)]
                _map(cells, wave, (common[0], common[1]), _BARE if column == 0 else ())
                if not np.any(wave.theta_p):
                    cells[1].text(
                        0.5, 0.7, "zero", transform=cells[1].transAxes, ha="center", color=SOFT, fontsize=9
                    )
                cells[1].tick_params(labelbottom=row == rows - 1)
                if row == 0:
                    cells[0].set_title(PATH_NAMES[path], fontsize=9, color=SOFT, loc="center")
                if row == rows - 1:
                    cells[1].set_xlabel("t (s)")
            place = grid[row, 0].get_position(drawing)
            drawing.text(0.13 / width, place.y1 + 0.02 / height, name, fontsize=9, va="bottom")
    return drawing


def row_names(result: Propagation) -> list[str]:
    """How the coordinates are called in a figure: the cart, then the angles by their number."""
    carts = sum(not name.startswith("theta") for name in result.coordinates)
    angles = range(1, len(result.coordinates) - carts + 1)
    return ["cart"] * carts + [rf"$\theta_{{{k}}}$" for k in angles]


def plain_names(result: Propagation) -> list[str]:
    """The same in plain text."""
    return [name.strip("$").replace(r"\theta_{", "\u03b8").replace("}", "") for name in row_names(result)]


def _surface(axes: Any, time: Vector, order: Vector, values: Vector, label: str) -> None:
    """One surface over a height of asinh; its two ends drawn as curves. It starts where all orders are bounded."""
    first = int(np.argmin(np.any(np.isnan(values), axis=1)))
    time, values = time[first:], values[first:]
    usual = float(np.nanmedian(np.abs(values))) or 1.0
    largest = float(np.max(size_of_orders(time, values)))
    high = float(np.arcsinh(largest / usual))
    height = np.arcsinh(np.clip(values, -largest, largest) / usual)
    t, orders = np.meshgrid(time, order, indexing="ij")
    axes.plot_surface(
        t, orders, height, rcount=_SEEN, ccount=order.size, cmap=_HUES, vmin=-high, vmax=high, linewidth=0,
        antialiased=False, rasterized=True,
    )  # fmt: skip
    for end, colour in ((0, INK), (-1, ACCENT)):
        axes.plot(
            time, np.full(time.shape, order[end]), height[:, end], color=colour, linewidth=0.8, zorder=9
        )
    ticks = _ticks(largest, usual)
    axes.set_zticks(np.arcsinh(np.array(ticks) / usual), [f"{tick:g}" for tick in ticks])
    axes.set(xlim=(time[0], time[-1]), ylim=(order[0], order[-1]), zlim=(-high, high))
    axes.set_xlabel("t (s)", labelpad=-9, fontsize=8)
    axes.set_ylabel(label, labelpad=-8, fontsize=8)
    axes.tick_params(labelsize=6.5, pad=-3)
    axes.locator_params(axis="x", nbins=4)
    axes.locator_params(axis="y", nbins=4)
    axes.view_init(elev=34, azim=-58)
    axes.set_box_aspect((1.35, 1.0, 0.75), zoom=1.3)
    for axis in (axes.xaxis, axes.yaxis, axes.zaxis):
        axis.set_pane_color((1.0, 1.0, 1.0, 0.0))


def _ticks(largest: float, usual: float) -> list[float]:
    """Zero and a few round values on both sides, a decade or more apart."""
    decade = 10.0 ** np.floor(np.log10(largest))
    top = decade * max(step for step in (1, 2, 5) if step * decade <= largest)
    reach = np.arcsinh(largest / usual)
    high = [top / 10**k for k in range(5)]
    # Closer to each other than a sixth of the height, labels would overlap.
    apart = [k for k, value in enumerate(high) if np.arcsinh(value / usual) > 0.35 * reach]
    shown = [high[k] for k in apart[:: max(1, len(apart) // 2)]]
    return [*(-value for value in shown), 0.0, *shown[::-1]]


def _wave(cells: list[list[Any]], wave: Wave, last: bool) -> None:
    """The map of one wave, and the sizes it was divided by."""
    _map([cells[0][0], cells[1][0]], wave, wave.sizes, _WHOLE)
    cells[1][0].tick_params(labelbottom=last)
    if last:
        cells[1][0].set_xlabel("t (s)")
    for axes, order, size in zip((cells[0][1], cells[1][1]), (wave.p, wave.alpha), wave.sizes, strict=True):
        axes.semilogx(size, order, color=ACCENT, linewidth=1.1)
        axes.set_yticks([])
        axes.spines["left"].set_visible(False)
    low = min(float(size.min()) for size in wave.sizes)
    high = max(float(size.max()) for size in wave.sizes)
    for axes, order in ((cells[0][1], wave.p), (cells[1][1], wave.alpha)):
        axes.set_xlim(low / 2, high * 2)
        axes.set_ylim((order[-1], order[0]) if axes is cells[0][1] else (order[0], order[-1]))
        axes.minorticks_off()
    cells[0][1].tick_params(labelbottom=False, length=0)
    cells[0][1].spines["bottom"].set_visible(False)
    cells[1][1].tick_params(labelsize=7)
    if last:
        cells[1][1].set_xlabel("size", fontsize=8)


def _map(cells: list[Any], wave: Wave, sizes: tuple[Vector, Vector], labels: tuple[str, ...]) -> None:
    """theta_p above psi on one time axis: the force on top, the acceleration where they meet, the angle at the foot."""
    for axes, order, values, size in zip(
        cells, (wave.p, wave.alpha), (wave.theta_p, wave.psi), sizes, strict=True
    ):
        axes.pcolormesh(
            wave.time,
            order,
            (values / size).T,
            cmap=_HUES,
            vmin=-1,
            vmax=1,
            shading="gouraud",
            rasterized=True,
        )
        axes.grid(False)
        axes.set_xlim(wave.time[0], wave.time[-1])
        axes.tick_params(labelleft=bool(labels), labelsize=7.5)
        for side in axes.spines.values():
            side.set_visible(True)
            side.set_linewidth(0.6)
    # Both axes run downwards along the signal: p rises from 0 to 1, alpha falls from 0 to -2.
    cells[0].set_ylim(wave.p[-1], wave.p[0])
    cells[1].set_ylim(wave.alpha[0], wave.alpha[-1])
    cells[0].tick_params(labelbottom=False, bottom=False)
    if labels:
        cells[0].set_yticks([wave.p[0], wave.p[-1]], labels[:2])
        cells[1].set_yticks([-1.0, wave.alpha[0]], labels[2:])
        for axes, letter in zip(cells, ("p", r"$\alpha$"), strict=True):
            axes.set_ylabel(letter, fontsize=8, rotation=0)
            axes.yaxis.set_label_coords(-0.035, 0.22)
