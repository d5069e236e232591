"""Fig. 2 of paper A at work: the inverse model before the direct one, and how well the motion is followed."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from phichain.control.computed_torque import Reference, tracking_error
from phichain.report import panels
from phichain.report.style import ACCENT, INK, SOFT, figure, look, shades

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from phichain.motion import Trajectory

_SMALLEST = 1e-17


def tracking(
    reference: Reference, runs: Mapping[str, Trajectory], displaced: Trajectory, title: str
) -> Figure:
    """The block diagram, the torques, the tracking errors of several runs, and how an initial error dies out.

    Args:
        reference: The wanted motion.
        runs: Name -> a run that starts on the wanted motion.
        displaced: A run that starts beside it.
        title: What is shown.
    """
    first = next(iter(runs.values()))
    with look():
        drawing = figure(11.0, 6.2)
        drawing.suptitle(title, x=0.01, ha="left", fontsize=11)
        grid = drawing.add_gridspec(3, 2, height_ratios=(0.75, 1.0, 1.0))
        _diagram(drawing.add_subplot(grid[0, :]))
        names = [rf"$T_{k + 1}$" for k in range(first.q.shape[1])]
        assert first.u is not None
        torques = drawing.add_subplot(grid[1, 0])
        panels.against_time(torques, first.t, first.u, names, "inverse model's torque (N m)")
        _motion(drawing.add_subplot(grid[2, 0], sharex=torques), reference, displaced)
        _errors(drawing.add_subplot(grid[1:, 1]), reference, runs, displaced)
    return drawing


def _diagram(axes: Any) -> None:
    """Wanted motion -> inverse model -> torque -> direct model -> motion, with the state fed back."""
    axes.set_axis_off()
    axes.set(xlim=(0, 10), ylim=(0, 2))
    boxes = ((2.6, r"inverse model  $I\ddot\theta + N + G$"), (6.3, r"direct model  $I^{-1}(T - N - G)$"))
    for at, words in boxes:
        frame = {"boxstyle": "square,pad=0.7", "facecolor": "white", "edgecolor": INK}
        axes.text(at, 1.25, words, ha="center", va="center", bbox=frame, fontsize=9.5)
    arrow = {"arrowstyle": "->", "color": INK, "shrinkA": 0, "shrinkB": 0}
    for start, stop, words in (
        (0.3, 1.45, r"$\theta_d, \dot\theta_d, \ddot\theta_d$"),
        (3.75, 5.1, "$T$"),
        (7.5, 9.4, r"$\theta, \dot\theta$"),
    ):
        axes.annotate("", (stop, 1.25), (start, 1.25), arrowprops=arrow)
        axes.text((start + stop) / 2, 1.42, words, ha="center", va="bottom", fontsize=9.5)
    axes.plot([8.6, 8.6, 2.6], [1.25, 0.25, 0.25], color=ACCENT, linestyle="--", linewidth=1.0)
    axes.annotate("", (2.6, 0.82), (2.6, 0.25), arrowprops={**arrow, "color": ACCENT, "linestyle": "--"})
    axes.text(5.6, 0.34, "computed torque: the state fed back", ha="center", color=ACCENT, fontsize=9)


def _motion(axes: Any, reference: Reference, displaced: Trajectory) -> None:
    """The wanted angles, dotted, and those of the run that starts beside them."""
    wanted = np.array([reference(float(t))[0] for t in displaced.t])
    names = [rf"$\theta_{k + 1}$" for k in range(wanted.shape[1])]
    for k, colour in enumerate(shades(wanted.shape[1])):
        axes.plot(displaced.t, wanted[:, k], color=colour, linestyle=":")
    panels.against_time(axes, displaced.t, displaced.q, names, "angle (rad), dotted: wanted")
    axes.set_xlabel("t (s)")


def _errors(axes: Any, reference: Reference, runs: Mapping[str, Trajectory], displaced: Trajectory) -> None:
    for (name, run), colour in zip(runs.items(), shades(len(runs)), strict=True):
        error = tracking_error(reference, run.t, run.q)
        axes.semilogy(run.t, np.maximum(error, _SMALLEST), color=colour, label=name, linewidth=0.9)
    beside = tracking_error(reference, displaced.t, displaced.q)
    axes.semilogy(displaced.t, np.maximum(beside, _SMALLEST), color=ACCENT, label="from a displaced start")
    axes.axhline(np.finfo(float).eps, color=SOFT, linewidth=0.8, linestyle=":")
    axes.set(xlabel="t (s)", ylabel=r"$\max_k |\theta_{d,k} - \theta_k|$ (rad)", xlim=(0.0, displaced.t[-1]))
    axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2)
