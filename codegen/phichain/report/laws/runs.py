"""Monte Carlo of a law: which draws held and which did not, and when the runs settled."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from phichain.report.style import ACCENT, INK, SOFT, figure, look

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from numpy.typing import NDArray


class Tried(Protocol):
    """What is drawn of `trials.Runs`."""

    @property
    def law(self) -> str: ...
    @property
    def error_names(self) -> tuple[str, ...]: ...
    @property
    def errors(self) -> NDArray[np.float64]: ...
    @property
    def starts(self) -> NDArray[np.float64]: ...
    @property
    def late(self) -> NDArray[np.int64]: ...
    @property
    def settled(self) -> NDArray[np.float64]: ...
    @property
    def held(self) -> NDArray[np.int64]: ...
    @property
    def seconds(self) -> float: ...
    @property
    def share(self) -> float: ...

    @property
    def interval(self) -> tuple[float, float]: ...


def scattered(runs: Tried) -> Figure:
    """Every number that was wrong, run by run, beside when the runs settled."""
    columns = [(name, runs.errors[:, k]) for k, name in enumerate(runs.error_names) if np.any(runs.errors[:, k])]
    columns += [("late (samples)", runs.late.astype(float))] if np.any(runs.late) else []
    columns = columns or [("start (rad)", np.max(np.abs(runs.starts - np.mean(runs.starts, axis=0)), axis=1))]
    kept = runs.held == 1
    with look():
        drawing = figure(9.6, 1.6 + 0.34 * len(columns) + 1.6)
        axes: Any = drawing.subplots(1, 2, width_ratios=(1.6, 1.0))
        for row, (_, values) in enumerate(columns):
            size = float(np.max(np.abs(values))) or 1.0
            for which, colour, side in ((kept, SOFT, 0.12), (~kept, ACCENT, -0.12)):
                axes[0].plot(values[which] / size, np.full(int(np.sum(which)), row - side), "|", color=colour, markersize=8)
        axes[0].set_yticks(np.arange(len(columns)), [f"{name}, ±{float(np.max(np.abs(values))):.3g}" for name, values in columns])
        axes[0].invert_yaxis()
        axes[0].set(xlabel="share of the largest", title="grey: held; colour, below: not", xlim=(-1.05, 1.05))
        if np.any(kept):
            axes[1].hist(runs.settled[kept], bins=30, color=INK)
        axes[1].set(xlabel="settled after (s)", ylabel="runs", xlim=(0.0, runs.seconds))
        low, high = runs.interval
        drawing.suptitle(f"{runs.law}: {runs.share:.1%} of {len(kept)} runs hold, 95 % interval {low:.1%} to {high:.1%}", fontsize="medium")
    return drawing
