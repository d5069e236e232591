"""The figures of phichain: a motion, a family of limit cycles, a controlled chain, and all of them on one sheet."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from phichain.report import panels
from phichain.report.geometry import tilt
from phichain.report.style import figure, look

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from phichain.continuation import Branch
    from phichain.simulate import Trajectory
    from phichain.system import System


def motion(system: System, trajectory: Trajectory) -> Figure:
    """A simulation: the chain in motion, the angle of every link from the vertical, and the energy's error."""
    with look():
        drawing = figure(8.4, 4.6)
        axes = drawing.subplot_mosaic([["chain", "angles"], ["chain", "energy"]], width_ratios=(1.0, 1.4))
        panels.chain_in_motion(axes["chain"], system, trajectory.q)
        axes["chain"].set_title(f"{trajectory.name}, {trajectory.t[0]:g} to {trajectory.t[-1]:g} s")
        angles(axes["angles"], system, trajectory)
        if trajectory.energy is None:
            axes["energy"].set_visible(False)
            axes["angles"].set_xlabel("t (s)")
        else:
            panels.energy_error(axes["energy"], trajectory.t, trajectory.energy)
            axes["energy"].set_title(f"by {trajectory.method}, tolerance {trajectory.tol:.0e}")
    return drawing


def angles(axes: Any, system: System, trajectory: Trajectory) -> None:
    """Angle of every link from the hanging vertical, over time."""
    names = [f"link {k}" for k in range(1, system.links + 1)]
    panels.against_time(axes, trajectory.t, tilt(system, trajectory.q), names, "link angle (rad)")


def closed_loop(system: System, trajectory: Trajectory, direction_error: Any, rate_error: Any) -> Figure:
    """A controlled chain on a cart: the motion, the errors that must vanish, the cart's position and its force.

    Args:
        system: The chain.
        trajectory: The closed loop's motion, with its input u.
        direction_error: e_q over time.
        rate_error: e_omega over time.
    """
    with look():
        drawing = figure(8.4, 5.4)
        layout: Any = [["chain", "errors"], ["chain", "cart"], ["chain", "force"]]
        axes = drawing.subplot_mosaic(layout, width_ratios=(1.0, 1.4))
        panels.chain_in_motion(axes["chain"], system, trajectory.q)
        axes["chain"].set_title(f"{trajectory.name}, {trajectory.t[0]:g} to {trajectory.t[-1]:g} s")
        panels.decay(axes["errors"], trajectory.t, {"$e_q$": direction_error, r"$e_\omega$": rate_error})
        axes["errors"].set_xlabel("")
        cart = trajectory.q[:, : system.cart_size]
        panels.against_time(axes["cart"], trajectory.t, cart, list(system.q_names[: system.cart_size]), "cart (m)")
        if trajectory.u is not None:
            panels.against_time(axes["force"], trajectory.t, trajectory.u, list(system.u_names), "force (N)")
        axes["force"].set_xlabel("t (s)")
    return drawing


def family(branch: Branch) -> Figure:
    """One family of limit cycles in paper A's axes, and over its energy where that is known."""
    with look():
        if branch.energy is None:
            drawing = figure(5.4, 4.0)
            panels.family(drawing.subplots(), branch)
            return drawing
        drawing = figure(8.4, 4.0)
        left, right = drawing.subplots(1, 2, sharey=True, width_ratios=(1.6, 1.0))
        panels.family(left, branch)
        panels.energy_of_family(right, branch)
        right.set_ylabel("")
    return drawing


def overview(
    first: tuple[System, Trajectory], second: tuple[System, Trajectory], branch: Branch, steadied: tuple[Any, Any]
) -> Figure:
    """The tour on one sheet: two chains in motion, a family of limit cycles, and an error that a controller removes.

    Args:
        first: A chain and its motion.
        second: Another one.
        branch: A family of limit cycles.
        steadied: Times, and the error e_q of a closed loop.
    """
    with look():
        drawing = figure(9.6, 6.4)
        layout: Any = [["first", "second"], ["family", "steadied"]]
        axes = drawing.subplot_mosaic(layout, height_ratios=(1.25, 1.0))
        for name, (system, trajectory) in (("first", first), ("second", second)):
            panels.chain_in_motion(axes[name], system, trajectory.q)
            axes[name].set_title(f"{trajectory.name}: released from rest, {trajectory.t[-1]:g} s")
        panels.family(axes["family"], branch)
        panels.decay(axes["steadied"], steadied[0], {"$e_q$, links 2 and 3 upright": steadied[1]})
    return drawing
