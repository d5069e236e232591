"""Figs 2 to 4 of paper B: the chain on a cart left alone, and steadied at an equilibrium; the same panels for both."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from phichain.control import errors
from phichain.report import panels
from phichain.report.geometry import directions, joints
from phichain.report.style import ACCENT, INK, SOFT, figure, look, shades

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from phichain.control import Gains
    from phichain.simulate import Trajectory
    from phichain.system import System

Vector = NDArray[np.float64]


def left_alone(system: System, motion: Trajectory, title: str, moments: Sequence[float]) -> Figure:
    """Fig. 2: snapshots, the cart, the heights of the links, the tip's path seen from the cart, the energies.

    Args:
        system: A spatial chain on a cart with `energy`.
        motion: Its motion without input.
        title: What is shown.
        moments: Times of the snapshots, s.
    """
    with look():
        drawing, cells = _sheet(title, system.links, ("cart", "energies", "drift"))
        _film(cells["film"], system, motion, moments)
        _cart(cells["cart"], system, motion)
        _heights(cells["heights"], system, motion)
        _energies(cells["energies"], system, motion)
        panels.energy_error(cells["drift"], motion.t, _total(motion))
        _tip(cells["side"], system, motion)
    return drawing


def steadied(system: System, motion: Trajectory, gains: Gains, title: str, moments: Sequence[float]) -> Figure:
    """Figs 3 and 4: snapshots, the cart, the heights of the links, the energies, e_q and e_omega, the control force.

    Args:
        system: A spatial chain on a cart with `energy`.
        motion: The closed loop's motion, with its input.
        gains: The regulator.
        title: What is shown.
        moments: Times of the snapshots, s.
    """
    with look():
        drawing, cells = _sheet(title, system.links, ("cart", "energies", "force"))
        _film(cells["film"], system, motion, moments)
        _cart(cells["cart"], system, motion)
        _heights(cells["heights"], system, motion)
        _energies(cells["energies"], system, motion)
        assert motion.u is not None
        panels.against_time(cells["force"], motion.t, motion.u, ["$u_1$", "$u_2$"], "force (N)")
        cells["force"].set_xlabel("t (s)")
        _decay(cells["side"], system, motion, gains)
    return drawing


def _sheet(title: str, links: int, middle: tuple[str, ...]) -> tuple[Figure, dict[str, Any]]:
    """A film strip over three columns: one large panel, the panels of `middle`, and one low panel per link."""
    drawing = figure(11.0, 7.6)
    drawing.suptitle(title, x=0.01, ha="left", fontsize=11)
    grid = drawing.add_gridspec(2, 3, height_ratios=(1.0, 2.6), width_ratios=(1.0, 1.15, 0.9))
    cells: dict[str, Any] = {"film": drawing.add_subplot(grid[0, :]), "side": drawing.add_subplot(grid[1, 0])}
    column = grid[1, 1].subgridspec(len(middle), 1)
    for row, name in enumerate(middle):
        cells[name] = drawing.add_subplot(column[row])
    rows = grid[1, 2].subgridspec(links, 1)
    cells["heights"] = [drawing.add_subplot(rows[k]) for k in range(links)]
    return drawing, cells


def _film(axes: Any, system: System, motion: Trajectory, moments: Sequence[float]) -> None:
    """The chain at chosen times beside each other, seen along the horizontal axis in which it moves least."""
    points = joints(system, motion.q)
    seen = points - points[:, :1]
    across = int(np.argmax(np.ptp(seen[:, -1, :2], axis=0)))
    reach = float(np.max(np.abs(seen[..., across]))) or 0.1
    spacing = 2.2 * reach
    for rank, moment in enumerate(moments):
        k = int(np.argmin(np.abs(motion.t - moment)))
        axes.plot(seen[k, :, across] + rank * spacing, -seen[k, :, 2], "-o", color=INK, linewidth=1.4, markersize=3.5)
        axes.plot(rank * spacing, 0.0, "s", color=ACCENT, markersize=8, zorder=3)
        axes.text(rank * spacing, 0.02, f"{moment:g} s", ha="center", va="bottom", color=SOFT, fontsize=8,
                  transform=axes.get_xaxis_transform())  # fmt: skip
    axes.axhline(0.0, color=SOFT, linewidth=0.8, zorder=0)
    axes.set_aspect("equal", adjustable="datalim")
    axes.set(ylabel="height (m)", xticks=[])
    axes.set_title(f"seen from the cart, across $e_{across + 1}$", fontsize=9, color=SOFT)
    low, high = axes.get_ylim()
    axes.set_ylim(low - 0.2 * (high - low), high)
    axes.grid(False)


def _cart(axes: Any, system: System, motion: Trajectory) -> None:
    names = [rf"$e_{k + 1} \cdot x$" for k in range(system.cart_size)]
    panels.against_time(axes, motion.t, motion.q[:, : system.cart_size], names, "cart (m)")


def _heights(cells: Sequence[Any], system: System, motion: Trajectory) -> None:
    """e_3 . q_i over time: 1 hangs, -1 stands."""
    down = directions(system, motion.q)[..., 2]
    for k, (axes, colour) in enumerate(zip(cells, shades(len(cells)), strict=True)):
        axes.plot(motion.t, down[:, k], color=colour, linewidth=0.9)
        axes.set(ylim=(-1.15, 1.15), yticks=[-1, 0, 1], xlim=(motion.t[0], motion.t[-1]))
        axes.set_ylabel(rf"$e_3 \cdot q_{k + 1}$", fontsize=8)
        axes.tick_params(labelbottom=k == len(cells) - 1)
    cells[-1].set_xlabel("t (s)")


def chain_kinetic_energy(system: System, motion: Trajectory) -> Vector:
    """T_q, the part of the kinetic energy that is left when the cart stands still, J, shape (m,); equation (10)."""
    rates = motion.v.copy()
    rates[:, : system.cart_size] = 0.0
    return np.asarray(system.energy(motion.q, rates)[0])


def _energies(axes: Any, system: System, motion: Trajectory) -> None:
    assert motion.kinetic is not None and motion.potential is not None
    axes.plot(motion.t, motion.kinetic, color=INK, label="$T$", linewidth=1.0)
    axes.plot(motion.t, chain_kinetic_energy(system, motion), color=ACCENT, label="$T_q$", linestyle=":")
    axes.plot(motion.t, motion.potential, color=SOFT, label="$V$", linewidth=1.0)
    axes.plot(motion.t, _total(motion), color=INK, label="$T + V$", linewidth=0.8, linestyle="--")
    axes.set(ylabel="energy (J)", xlim=(motion.t[0], motion.t[-1]))
    axes.legend(ncols=4, loc="lower left", bbox_to_anchor=(0.0, 1.0), borderaxespad=0.2, handlelength=1.2)


def _total(motion: Trajectory) -> Vector:
    assert motion.energy is not None
    return motion.energy


def _tip(axes: Any, system: System, motion: Trajectory) -> None:
    """The path of the last mass seen from the cart, in the e_1-e_3 plane, within what the chain can reach."""
    points = joints(system, motion.q)
    tip = points[:, -1] - points[:, 0]
    reach = float(np.sum(np.linalg.norm(np.diff(points[0], axis=0), axis=-1)))
    turn = np.linspace(0.0, 2 * np.pi, 200)
    axes.plot(reach * np.cos(turn), reach * np.sin(turn), color=SOFT, linewidth=0.7, linestyle=":")
    axes.plot(tip[:, 0], -tip[:, 2], color=INK, linewidth=0.7)
    axes.plot(tip[0, 0], -tip[0, 2], "o", color=ACCENT, markersize=5)
    axes.plot(0.0, 0.0, "s", color=ACCENT, markersize=8)
    axes.set_aspect("equal")
    axes.set(xlabel="$e_1$ (m)", ylabel="height (m)")
    axes.set_title("last mass, seen from the cart", fontsize=9, color=SOFT)


def _decay(axes: Any, system: System, motion: Trajectory, gains: Gains) -> None:
    """e_q and e_omega on a logarithmic scale, with the rate of the slowest eigenvalue."""
    direction, rate = errors(system, gains, motion.x)
    panels.decay(axes, motion.t, {"$e_q$": direction, r"$e_\omega$ (rad/s)": rate})
    slowest = float(gains.poles[0].real)
    guide = direction[-1] * np.exp(slowest * (motion.t - motion.t[-1]))
    shown = guide < 3.0 * np.max(direction)
    axes.semilogy(motion.t[shown], 3.0 * guide[shown], color=SOFT, linestyle="--", label=f"$e^{{{slowest:.4f} t}}$")
    axes.legend(loc="upper right")
    axes.set_title("errors", fontsize=9, color=SOFT)
