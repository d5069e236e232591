"""Work-precision diagrams: error down, time across, both logarithmic; one curve per method."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from phichain.report.style import figure, look, save

_MARKS = "osD^vP*X<>h8"
_LEAST = 1e-17
_OWN, _OTHER = (
    ("#c2410c", "#a16207", "#7c2d12", "#db2777", "#dc8a2b"),
    ("#1d4e89", "#3f8f8b", "#6b7fa3", "#4b5563", "#7fa650", "#9a7fbf"),
)


@dataclass(frozen=True)
class Curve:
    """One method.

    Attributes:
        label: Its name.
        seconds: Times.
        errors: Errors; zeros are drawn at 1e-17.
        own: Whether it is phichain's: warm colours, full lines.
    """

    label: str
    seconds: Sequence[float]
    errors: Sequence[float]
    own: bool


def draw_work_precision(
    path: Path | str, title: str, curves: Sequence[Curve], floor: float | None = None
) -> Path:
    """Draw one diagram as PNG.

    Args:
        path: The file.
        title: What was worked on.
        curves: The methods; points that are not finite are left out.
        floor: Attainable error, drawn as a line.
    """
    with look():
        drawing = figure(8.6, 4.6)
        axes = drawing.add_subplot()
        counts = {True: 0, False: 0}
        for k, curve in enumerate(curves):
            colours = _OWN if curve.own else _OTHER
            colour = colours[counts[curve.own] % len(colours)]
            counts[curve.own] += 1
            seconds, errors = np.array(curve.seconds, dtype=float), np.maximum(curve.errors, _LEAST)
            good = np.isfinite(seconds) & np.isfinite(errors)
            if not good.any():
                continue
            style = "-" if curve.own else "--"
            axes.plot(
                seconds[good], errors[good], style, marker=_MARKS[k % len(_MARKS)], color=colour, label=curve.label,
                markersize=4.5, linewidth=1.8 if curve.own else 1.0,
            )  # fmt: skip
        if floor is not None:
            axes.axhline(floor, color="#8b95a3", linewidth=0.8, linestyle=":")
            axes.text(
                0.995,
                floor,
                "round-off x condition",
                transform=axes.get_yaxis_transform(),
                ha="right",
                va="bottom",
                fontsize=7,
            )
        axes.set_xscale("log")
        axes.set_yscale("log")
        axes.set_xlabel("processor time, s")
        axes.set_ylabel("error")
        axes.set_title(title)
        drawing.legend(loc="outside right upper", fontsize=7)
        return save(drawing, path)
