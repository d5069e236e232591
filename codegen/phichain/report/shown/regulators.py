"""Regulators, how far they hold, and parameters fitted to a measurement."""

from __future__ import annotations

from typing import Any

import numpy as np

from phichain.control import Gains
from phichain.control.reach import Attraction, AttractionMap
from phichain.identification import Fit
from phichain.report import figures
from phichain.report.laws import attraction
from phichain.report.shown.kinds import demand_figure, plot
from phichain.report.style import ACCENT, INK, SOFT, figure, look


@plot.register
def _(record: Gains, ax: Any = None) -> Any:
    """A regulator: the poles of its closed loop over those of the open one, in the complex plane."""
    if ax is None:
        with look():
            drawing = figure(5.4, 4.2)
            _poles(drawing.add_subplot(), record)
        return drawing
    _poles(ax, record)
    return ax


def _poles(axes: Any, record: Gains) -> None:
    loose = np.linalg.eigvals(record.A)
    axes.axvline(0.0, color=SOFT, linewidth=0.8)
    axes.plot(loose.real, loose.imag, "x", color=SOFT, label="without control")
    axes.plot(record.poles.real, record.poles.imag, "o", color=ACCENT, markersize=4, label="under control")
    axes.set(xlabel="real part (1/s)", ylabel="imaginary part (rad/s)")
    axes.set_title(f"{record.name}: slowest decay {record.decay:.3g} 1/s", color=INK)
    axes.legend(loc="lower left", bbox_to_anchor=(0.0, -0.32), ncols=2)


@plot.register
def _(record: Attraction, ax: Any = None) -> Any:
    """Radii of all equilibria, by size."""
    demand_figure(ax, record)
    return attraction.radii(record)


@plot.register
def _(record: AttractionMap, ax: Any = None) -> Any:
    """When the starts of a plane come home."""
    demand_figure(ax, record)
    return attraction.region(record)


@plot.register
def _(record: Fit, ax: Any = None) -> Any:
    """Measured and fitted columns, what is left, how well the parameters are known."""
    demand_figure(ax, record)
    return figures.fitted(record)
