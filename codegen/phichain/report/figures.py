"""The figures of phichain: a motion, a family of limit cycles, a controlled chain, and all of them on one sheet."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from phichain.report import panels
from phichain.report.geometry import Drawn, tilt
from phichain.report.orbits.families import against_amplitude, family
from phichain.report.orbits.motion import orbit
from phichain.report.style import figure, look

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from phichain.continuation import Branch
    from phichain.identification import Fit
    from phichain.motion import Trajectory
    from phichain.system import System

__all__ = ["against_amplitude", "angles", "closed_loop", "family", "fitted", "motion", "orbit", "overview"]


def motion(system: Drawn, trajectory: Trajectory) -> Figure:
    """A simulation: the chain in motion, the angle of every link from the vertical, and the error of its energy (of E - work + loss
    where work is done or lost)."""
    with look():
        drawing, axes = _with_chain(system, trajectory, ["angles", "energy"], 4.6)
        angles(axes["angles"], system, trajectory)
        if trajectory.energy is None:
            axes["energy"].set_visible(False)
            axes["angles"].set_xlabel("t (s)")
        else:
            balance = None if trajectory.work is None else trajectory.balance
            panels.energy_error(axes["energy"], trajectory.t, trajectory.energy, balance)
            axes["energy"].set_title(f"by {trajectory.method}, tolerance {trajectory.tol:.0e}")
    return drawing


def _with_chain(system: Drawn, trajectory: Trajectory, rows: list[str], height: float) -> tuple[Figure, dict[str, Any]]:
    """A figure with the chain in motion to the left, one in space in three views and in perspective, and axes of these names to the right."""
    title = f"{trajectory.name}, {trajectory.t[0]:g} to {trajectory.t[-1]:g} s"
    if system.is_planar:
        drawing = figure(8.4, height)
        layout: Any = [["chain", row] for row in rows]
        axes: dict[str, Any] = drawing.subplot_mosaic(layout, width_ratios=(1.0, 1.4))
        panels.chain_in_motion(axes["chain"], system, trajectory.q)
        axes["chain"].set_title(title)
        return drawing, axes
    drawing = figure(11.0, max(height, 5.0))
    halves: Any = drawing.subfigures(1, 2, width_ratios=(1.1, 1.0))
    left, right = halves
    left.suptitle(title, fontsize=10)
    for place, (words, across, up) in enumerate(panels.VIEWS, 1):
        view = left.add_subplot(2, 2, place)
        panels.chain_in_motion(view, system, trajectory.q, view=(across, up))
        view.set_title(words, fontsize=8)
    panels.chain_in_space(left.add_subplot(2, 2, 4, projection="3d"), system, trajectory.q)
    found = right.subplots(len(rows), 1, squeeze=False)[:, 0]
    return drawing, dict(zip(rows, found, strict=True))


def angles(axes: Any, system: Drawn, trajectory: Trajectory) -> None:
    """Angle of every link from the hanging vertical, over time; grey where the run does not hold any more."""
    names = [f"link {k}" for k in range(1, system.links + 1)]
    panels.against_time(axes, trajectory.t, tilt(system, trajectory.q), names, "link angle (rad)")
    panels.beyond(axes, trajectory.holds_until, float(trajectory.t[-1]))


def closed_loop(system: System, trajectory: Trajectory, direction_error: Any, rate_error: Any) -> Figure:
    """A controlled chain: the motion, the errors that must vanish, the cart's position if there is one, and the input.

    Args:
        system: The chain.
        trajectory: The closed loop's motion, with its input u.
        direction_error: e_q over time.
        rate_error: e_omega over time.
    """
    rows = ["errors", "cart", "input"] if system.has_cart else ["errors", "input"]
    with look():
        drawing, axes = _with_chain(system, trajectory, rows, 1.8 * len(rows))
        panels.decay(axes["errors"], trajectory.t, {"$e_q$": direction_error, r"$e_\omega$ (rad/s)": rate_error})
        axes["errors"].set_xlabel("")
        if system.has_cart:
            place = trajectory.q[:, : system.cart_size]
            panels.against_time(
                axes["cart"], trajectory.t, place, system.q_names[: system.cart_size], "cart (m)"
            )
        if trajectory.u is not None:
            panels.against_time(
                axes["input"], trajectory.t, trajectory.u, system.u_names, _input_label(system)
            )
        axes["input"].set_xlabel("t (s)")
    return drawing


def _input_label(system: System) -> str:
    kinds = {name.partition("_")[0] for name in system.u_names}
    labels = {"force": "force (N)", "torque": "torque (N m)", "acceleration": "acceleration (m/s$^2$)"}
    return labels[kinds.pop()] if len(kinds) == 1 and kinds <= set(labels) else "input (N, N m)"


def fitted(fit: Fit) -> Figure:
    """A fit: every measured column over its prediction and what is left of it, standard errors, and what moves together."""
    import numpy as np

    count = len(fit.columns)
    with look():
        drawing = figure(9.6, 2.2 + 1.9 * count)
        halves: Any = drawing.subfigures(1, 2, width_ratios=(1.7, 1.0))
        left, right = halves
        axes = left.subplots(2 * count, 1, sharex=True, squeeze=False, height_ratios=(1.6, 1.0) * count)[:, 0]
        for k, name in enumerate(fit.columns):
            panels.column_of_fit(axes[2 * k], axes[2 * k + 1], fit.t, fit.measured[:, k], fit.fitted[:, k], name)
        axes[0].set_title(f"{fit.name}: {len(fit.t)} rows")
        axes[-1].set_xlabel("t (s)")
        above, below = right.subplots(2, 1, height_ratios=(1.0, 1.4))
        share = fit.standard_error[: fit.count] / np.maximum(np.abs(fit.values[: fit.count]), np.finfo(float).tiny)
        panels.relative_errors(above, fit.names[: fit.count], share)
        panels.correlations(below, fit.names, fit.correlation)
    return drawing


def overview(
    first: tuple[System, Trajectory], second: tuple[System, Trajectory], branch: Branch, steadied: Trajectory
) -> Figure:
    """The tour on one sheet: two chains in motion, a family of limit cycles, and a chain that a controller steadies.

    Args:
        first: A chain and its motion.
        second: Another one, on a cart.
        branch: A family of limit cycles.
        steadied: The second chain under control.
    """
    with look():
        drawing = figure(9.6, 7.0)
        axes = drawing.subplots(2, 2, height_ratios=(1.1, 1.0))
        for place, (system, trajectory), what in (
            (axes[0, 0], first, "released from rest"),
            (axes[0, 1], second, "released from rest"),
            (axes[1, 1], (second[0], steadied), "balanced"),
        ):
            panels.chain_in_motion(place, system, trajectory.q)
            place.set_title(f"{trajectory.name}: {what}, {trajectory.t[-1]:g} s")
        against_amplitude(axes[1, 0], branch)
    return drawing
