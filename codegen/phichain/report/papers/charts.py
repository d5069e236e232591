"""Fig. 7 of paper A: where one harmonic balances the chain, where that is true, and where it goes as N grows.

Each chart is a family Phi(A, omega) = 0 followed by arclength from small motions, one family per linear mode. Drawn over
them are the exact curve of one link and periodic orbits of the full equations at their turning points, which carry all
harmonics: where they leave the curves, one harmonic stops being true.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib.resources import files
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import ellipkm1, jn_zeros

from phichain.report.style import ACCENT, INK, SOFT, figure, look, shades

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from phichain.continuation import Branch

Vector = NDArray[np.float64]


@dataclass(frozen=True)
class Orbit:
    """A periodic orbit of paper A's chain, m = l = 1/N, masses at the middles of the links, g = 9.81 m/s^2.

    Attributes:
        links: N.
        mode: The linear mode its family starts from, counted from 1.
        theta0: Relative angles at the turning point (N,), rad.
        omega: Angular frequency, rad/s.
        stable: Whether all Floquet multipliers lie on the unit circle.
    """

    links: int
    mode: int
    theta0: tuple[float, ...]
    omega: float
    stable: bool


def known_orbits() -> tuple[Orbit, ...]:
    """Thirteen orbits to sixteen digits, by shooting in quadruple precision."""
    text = files("phichain.report.papers").joinpath("limit_cycles.json").read_text(encoding="utf-8")
    return tuple(Orbit(**{**entry, "theta0": tuple(entry["theta0"])}) for entry in json.loads(text)["orbits"])


def pendulum_frequency(amplitude: ArrayLike, omega_0: float) -> Vector:
    """omega = pi omega_0 / (2 K(k)), k = sin(A/2): the exact frequency of one link, rad/s.

    K is taken at the complementary parameter cos^2(A/2), which keeps its digits near A = pi.

    Args:
        amplitude: A in rad, |A| < pi.
        omega_0: sqrt(g/r), the frequency of small motions, rad/s.
    """
    half = np.asarray(amplitude, dtype=float) / 2
    return np.asarray(np.pi * omega_0 / (2 * ellipkm1(np.cos(half) ** 2)))


def hanging_chain_frequency(length: float = 1.0, gravity: float = 9.81) -> float:
    """(j_{0,1} / 2) sqrt(g / L): the lowest frequency of a hanging chain, rad/s, the limit of N links."""
    return float(jn_zeros(0, 1)[0] / 2 * np.sqrt(gravity / length))


def charts(
    families: Mapping[int, Sequence[Branch]], slowest: Mapping[int, Branch], omega_0: float,
    exact: Mapping[int, Sequence[Branch]] | None = None,
) -> Figure:  # fmt: skip
    """One chart per mode of N = 1, 2, ... links in a triangle, and the slowest family as N grows beside it.

    Args:
        families: N -> its families, one per mode.
        slowest: N -> the family of mode 1, for N as large as wanted.
        omega_0: Frequency of small motions of the single link, rad/s.
        exact: N -> the families of the whole equations, one per mode, drawn over them.
    """
    count = max(families)
    orbits = known_orbits()
    with look():
        drawing = figure(2.85 * count, 2.45 * count)
        grid = drawing.add_gridspec(count, count)
        for row, (links, branches) in enumerate(sorted(families.items())):
            for column, branch in enumerate(branches):
                axes = drawing.add_subplot(grid[row, column])
                known = [orbit for orbit in orbits if (orbit.links, orbit.mode) == (links, column + 1)]
                _chart(axes, branch, known)
                if exact is not None:
                    _over(axes, exact[links][column], branch)
                axes.set_title(f"N = {links}" + (f", mode {column + 1}" if links > 1 else ""))
                axes.set_ylabel(r"$\omega$ (rad/s)" if column == 0 else "")
                axes.set_xlabel("amplitude (rad)" if row == count - 1 else "")
                if links == 1:
                    _exact(axes, omega_0)
        if count > 2:
            _legend(drawing.add_subplot(grid[0, 1]), count)
            _settling(drawing.add_subplot(grid[: count // 2, 2:]), slowest)
    return drawing


def _chart(axes: Any, branch: Branch, known: Sequence[Orbit]) -> None:
    """omega over the amplitude of every link, with the orbits known of that family."""
    omega = branch.column("omega")
    angles = [name for name in branch.names if name.startswith("amplitude_theta")]
    for k, (name, colour) in enumerate(zip(angles, shades(4), strict=False)):
        axes.plot(branch.column(name), omega, color=colour)
        for orbit in known:
            face = colour if orbit.stable else "white"
            axes.plot(
                orbit.theta0[k],
                orbit.omega,
                "o",
                color=colour,
                markerfacecolor=face,
                markersize=4.5,
                zorder=5,
            )
    axes.axvline(0.0, color=SOFT, linewidth=0.6)
    axes.margins(y=0.08)


def _over(axes: Any, branch: Branch, harmonic: Branch) -> None:
    """The exact family, dotted: where it leaves the curves of its colours, one harmonic is not true.

    An orbit half a period later is its own mirror image: of both the one is drawn whose large angles lie on one harmonic's side.
    """
    omega = branch.column("omega")
    names = [name for name in branch.names if name.startswith("theta")]
    largest = int(np.argmax(np.abs(harmonic.points[-1, :-1])))
    own = branch.column(names[largest])
    furthest = float(own[int(np.argmax(np.abs(own)))])
    side = -1.0 if abs(furthest) > 1 and furthest * harmonic.points[-1, largest] < 0 else 1.0
    for name, colour in zip(names, shades(4), strict=False):
        axes.plot(side * branch.column(name), omega, color=colour, linestyle=":", linewidth=1.8, dash_capstyle="round")


def _exact(axes: Any, omega_0: float) -> None:
    amplitude = np.linspace(0.0, np.pi - 1e-6, 400)
    axes.plot(amplitude, pendulum_frequency(amplitude, omega_0), color=ACCENT, linestyle="--")


def _legend(axes: Any, links: int) -> None:
    """What the lines and points mean, in the corner that the triangle leaves free."""
    axes.set_axis_off()
    for k, colour in enumerate(shades(4)[:links]):
        axes.plot([], [], color=colour, label=f"$A_{k + 1}$ by one harmonic")
    axes.plot([], [], color=ACCENT, linestyle="--", label="exact, one link")
    axes.plot([], [], color=INK, linestyle=":", linewidth=1.8, label="exact family")
    axes.plot([], [], "o", color=INK, markersize=4.5, label="true orbit, stable")
    axes.plot([], [], "o", color=INK, markerfacecolor="white", markersize=4.5, label="true orbit, unstable")
    axes.legend(loc="center", fontsize=8.5)


def _settling(axes: Any, slowest: Mapping[int, Branch]) -> None:
    """The slowest family over the first link's amplitude for more and more links, and how fast its foot settles."""
    limit = hanging_chain_frequency()
    for (links, branch), colour in zip(sorted(slowest.items()), shades(len(slowest)), strict=True):
        first, omega = branch.column("amplitude_theta_1"), branch.column("omega")
        turn = int(np.argmax(np.diff(first) < 0)) or len(first)
        axes.plot(first[: turn + 1], omega[: turn + 1], color=colour, label=f"N = {links}")
    axes.plot(0.0, limit, "D", color=ACCENT, markersize=6, zorder=5, clip_on=False, label="hanging chain")
    axes.set(xlabel="amplitude of the first link (rad)", ylabel=r"$\omega$ (rad/s)", xlim=(0.0, None))
    axes.set_title("slowest mode, up to its first fold")
    axes.legend(loc="upper right", ncols=2)
    inset = axes.inset_axes((0.09, 0.09, 0.34, 0.2))
    counts = np.array(sorted(slowest))
    gaps = [slowest[links].column("omega")[0] - limit for links in counts]
    inset.loglog(counts, gaps, "o", color=INK, markersize=3.5)
    inset.loglog(counts, gaps[-1] * (counts[-1] / counts) ** 2.0, color=ACCENT, linewidth=0.9)
    inset.set_title(r"$\omega(N) - \omega(\infty)$, line: $N^{-2}$", fontsize=8)
    inset.set_xticks(counts, [str(n) for n in counts])
    inset.minorticks_off()
    inset.tick_params(labelsize=7)
