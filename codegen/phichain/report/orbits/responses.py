"""Frequency responses drawn: amplitude over the forcing's frequency, what is stable told from what is not, every event marked."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np

from phichain.report.style import SOFT, figure, look, shades

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from phichain.orbits.forced import Response
    from phichain.system import System

_MARKS: Final = {"fold": "o", "symmetry breaking": "s", "period doubling": "D", "neimark-sacker": "^", "branch point": "P"}


def response(found: Response) -> Figure:
    """Peaks of the links over omega, and the phase of their first harmonics against the forcing."""
    with look():
        drawing = figure(6.4, 5.6)
        above, below = drawing.subplots(2, 1, sharex=True, height_ratios=(2.2, 1.0))
        peaks(above, found)
        phases(below, found)
        above.set_title(f"{found.scene}: {found.place}, {found.amplitude:g} {found.unit} cos($\\omega t$)")
    return drawing


def peaks(axes: Any, found: Response) -> None:
    """Largest angles over omega: full lines where motions are stable, dotted ones elsewhere."""
    angles = _angles(found)
    for k, colour in zip(angles, shades(len(angles)), strict=True):
        # Beyond pi an angle says no longer where its link is.
        peak = np.where(found.peak[:, k] <= np.pi, found.peak[:, k], np.nan)
        axes.plot(found.omega, peak, color=colour, linestyle=":", linewidth=1.0)
        axes.plot(found.omega, np.where(_held(found.stable), peak, np.nan), color=colour, label=_name(found.names[k]))
    for kind, mark in _MARKS.items():
        events = found.located(kind)
        for k, colour in zip(angles if events else (), shades(len(angles)), strict=False):
            places = [(event.omega, event.peak[k]) for event in events]
            label = kind if k == angles[0] else None
            axes.plot(*np.transpose(places), mark, color=colour, markersize=5, markerfacecolor="white", label=label)
    axes.set(ylabel="peak (rad)")
    axes.autoscale(axis="y")
    axes.set_ylim(bottom=0.0)
    axes.legend(loc="upper right")


def spectra(axes: Any, system: System, orbits: np.ndarray) -> None:
    """Sizes of the harmonics of brake orbits, largest link, over their numbers: straight lines on a logarithmic scale, the steeper the smaller.

    Args:
        axes: Where to draw.
        system: The chain, with what harmonic balance calls.
        orbits: (q_0, omega) of each (m, n + 1).
    """
    from phichain.orbits.harmonics.condensed import condensed_problem
    from phichain.orbits.modes import linear_modes

    modes = linear_modes(system)
    problem = condensed_problem(system, omega=float(modes.omega[0]), shape=modes.shapes[:, 0])
    for z, colour in zip(orbits, shades(len(orbits)), strict=True):
        sizes = np.max(np.abs(problem.evaluate(z).extra.found.coefficients), axis=1)
        largest = np.max(np.abs(z[system.cart_size : -1]))
        axes.semilogy(2 * np.arange(len(sizes)) + 1, sizes, ".-", color=colour, markersize=4, linewidth=0.8, label=f"{largest:.2g} rad")
    axes.set(xlabel="harmonic", ylabel="amplitude (rad)")
    axes.legend(loc="upper right")


def phases(axes: Any, found: Response) -> None:
    """By how much the first harmonic of every link lags behind the forcing."""
    angles = _angles(found)
    for k, colour in zip(angles, shades(len(angles)), strict=True):
        lag = np.unwrap(-np.angle(found.first[:, k]))
        axes.plot(found.omega, lag, color=colour, linestyle=":", linewidth=1.0)
        axes.plot(found.omega, np.where(_held(found.stable), lag, np.nan), color=colour)
    axes.axhline(np.pi / 2, color=SOFT, linewidth=0.8)
    axes.set(xlabel=r"$\omega$ (rad/s)", ylabel="lag (rad)")


def _held(stable: np.ndarray) -> np.ndarray:
    """Points that are stable, or end a stretch that is: lines meet at the events."""
    return np.asarray(stable | np.roll(stable, 1) & (np.arange(len(stable)) > 0))


def _angles(found: Response) -> list[int]:
    return [k for k, name in enumerate(found.names) if "theta" in name] or list(range(len(found.names)))


def _name(name: str) -> str:
    return f"$\\theta_{{{name.rpartition('_')[2]}}}$"
