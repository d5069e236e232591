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
    from phichain.motion import Trajectory
    from phichain.system import System

Vector = NDArray[np.float64]

_FILM = 5.6
"""Width of the film strip over its height."""

_EARLY = 0.4
"""The share of a steadied motion that its panels show; the errors are shown to the end."""


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
        _heights(cells["links"], system, motion)
        _energies(cells["energies"], system, motion)
        panels.energy_error(cells["drift"], motion.t, _total(motion))
        cells["drift"].set_ylabel("error of $T + V$")
        _tip(cells["side"], system, motion)
    return drawing


def steadied(
    system: System, motion: Trajectory, gains: Gains, title: str, moments: Sequence[float]
) -> Figure:
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
        _tilts(cells["links"], system, motion, gains)
        _energies(cells["energies"], system, motion)
        assert motion.u is not None
        panels.against_time(cells["force"], motion.t, motion.u, ["$u_1$", "$u_2$"], "force (N)")
        cells["force"].set_xlabel("t (s)")
        span = motion.t[-1] - motion.t[0]
        for axes in (cells["cart"], cells["energies"], cells["force"], *cells["links"]):
            axes.set_xlim(motion.t[0], motion.t[0] + _EARLY * span)
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
    cells["links"] = [drawing.add_subplot(rows[k]) for k in range(links)]
    return drawing, cells


def _film(axes: Any, system: System, motion: Trajectory, moments: Sequence[float]) -> None:
    """The chain at chosen times beside each other, seen along the horizontal axis in which it moves least."""
    points = joints(system, motion.q)
    seen = points - points[:, :1]
    across = int(np.argmax(np.ptp(seen[:, -1, :2], axis=0)))
    frames = seen[[int(np.argmin(np.abs(motion.t - moment))) for moment in moments]]
    low, high = min(-float(frames[..., 2].max()), 0.0), max(-float(frames[..., 2].min()), 0.0)
    margin = 0.12 * (high - low)
    spacing = max(
        2.1 * float(np.max(np.abs(frames[..., across]))), _FILM * (high - low + 3 * margin) / len(moments)
    )
    for rank, (frame, moment) in enumerate(zip(frames, moments, strict=True)):
        axes.plot(
            frame[:, across] + rank * spacing, -frame[:, 2], "-o", color=INK, linewidth=1.3, markersize=3.0
        )
        axes.plot(rank * spacing, 0.0, "s", color=ACCENT, markersize=6, zorder=3)
        axes.text(rank * spacing, low - 1.7 * margin, f"{moment:g} s", ha="center", color=SOFT, fontsize=8)
    axes.axhline(0.0, color=SOFT, linewidth=0.8, zorder=0)
    axes.set(xlim=(-0.6 * spacing, (len(moments) - 0.4) * spacing), ylim=(low - 2 * margin, high + margin))
    # Limits that may give way to the aspect, without a warning about it.
    axes.set_autoscale_on(True)
    axes.set_aspect("equal", adjustable="datalim")
    axes.set(ylabel="height (m)", xticks=[])
    axes.set_title(f"seen from the cart, across $e_{across + 1}$", fontsize=9, color=SOFT)
    axes.grid(False)


def _cart(axes: Any, system: System, motion: Trajectory) -> None:
    names = [rf"$e_{k + 1} \cdot x$" for k in range(system.cart_size)]
    panels.against_time(axes, motion.t, motion.q[:, : system.cart_size], names, "cart (m)")


def _heights(cells: Sequence[Any], system: System, motion: Trajectory) -> None:
    """e_3 . q_i over time: 1 hangs, -1 stands."""
    down = directions(system, motion.q)[..., 2]
    names = [rf"$e_3 \cdot q_{k + 1}$" for k in range(system.links)]
    _stack(cells, motion.t, down, names)
    for axes in cells:
        axes.set(ylim=(-1.15, 1.15), yticks=[-1, 0, 1])


def _tilts(cells: Sequence[Any], system: System, motion: Trajectory, gains: Gains) -> None:
    """The angle of every link from where it is to point, in degrees."""
    links = directions(system, motion.q)
    sideways = np.hypot(links[..., 0], links[..., 1])
    tilt = np.degrees(np.arctan2(sideways, np.array(gains.s) * links[..., 2]))
    _stack(cells, motion.t, tilt, [f"$q_{k + 1}$ off (deg)" for k in range(system.links)])


def _stack(cells: Sequence[Any], t: Vector, values: Vector, names: Sequence[str]) -> None:
    """One low panel per link."""
    for axes, curve, colour, name in zip(cells, values.T, shades(len(cells)), names, strict=True):
        axes.plot(t, curve, color=colour, linewidth=0.9)
        axes.set(xlim=(t[0], t[-1]))
        axes.set_ylabel(name, fontsize=8)
        axes.tick_params(labelbottom=axes is cells[-1])
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
    axes.semilogy(
        motion.t[shown], 3.0 * guide[shown], color=SOFT, linestyle="--", label=f"$e^{{{slowest:.4f} t}}$"
    )
    axes.legend(loc="upper right")
    axes.set_title("errors", fontsize=9, color=SOFT)
