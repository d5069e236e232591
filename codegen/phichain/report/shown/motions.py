"""Motions: simulated, periodic, planned, from saddle to saddle."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from phichain.control.swing_up import Plan
from phichain.errors import UnsupportedError
from phichain.motion import Trajectory
from phichain.orbits import Orbit
from phichain.orbits.connections import Connection
from phichain.records import Held
from phichain.report import figures, panels
from phichain.report.geometry import Kept, outline, tilt
from phichain.report.laws.swing_up import strip
from phichain.report.moving import write_motion
from phichain.report.orbits import animation
from phichain.report.orbits.connections import connections
from phichain.report.orbits.motion import orbit
from phichain.report.shown.kinds import animate, demand_figure, plot


@dataclass(frozen=True, eq=False)
class Played(Held):
    """Samples of a motion, as a moving picture asks for them.

    Attributes:
        name: What moves.
        t: Times (m,), s.
        q: Configurations (m, nq).
    """

    name: str
    t: np.ndarray
    q: np.ndarray

    def resample(self, points: int) -> Played:
        """The same at even times, on straight lines between the samples."""
        t = np.linspace(self.t[0], self.t[-1], points)
        return Played(self.name, t, np.column_stack([np.interp(t, self.t, column) for column in self.q.T]))


@plot.register
def _(record: Trajectory, ax: Any = None, *, of: str = "angles") -> Any:
    """A motion: the chain, its angles and its energy; on axes one of "angles", "chain" and "energy"."""
    drawn: dict[str, Callable[[Any], None]] = {
        "angles": lambda axes: figures.angles(axes, outline(record), record),
        "chain": lambda axes: panels.chain_in_motion(axes, outline(record), record.q),
        "energy": lambda axes: _energy(axes, record),
    }
    if of not in drawn:
        raise UnsupportedError("of", of, "is no panel of a motion", f"use one of {', '.join(drawn)}")
    if ax is None:
        return figures.motion(outline(record), record)
    drawn[of](ax)
    return ax


def _energy(axes: Any, record: Trajectory) -> None:
    if record.energy is None:
        raise UnsupportedError("of", "energy", "was not recorded", 'add "energy" to [functions] want of the scene')
    panels.energy_error(axes, record.t, record.energy, None if record.work is None else record.balance)


@plot.register
def _(record: Orbit, ax: Any = None) -> Any:
    """An orbit: the chain, its links over one period, its multipliers; on axes the links."""
    if ax is None:
        return orbit(outline(record), record)
    _links(ax, record, record.t, record.q)
    return ax


@plot.register
def _(record: Plan, ax: Any = None) -> Any:
    """A planned motion: a strip of pictures, angles, the cart's place and inputs; on axes the links."""
    if ax is None:
        return strip(outline(record), record)
    _links(ax, record, record.t, record.x[:, : record.x.shape[1] // 2])
    return ax


@plot.register
def _(record: Connection, ax: Any = None) -> Any:
    """A connection: its way over the angles, over time, and the chain."""
    demand_figure(ax, record)
    return connections(outline(record), [record])


def _links(axes: Any, record: Kept, t: np.ndarray, q: np.ndarray) -> None:
    """Every link's angle from hanging over time."""
    chain = outline(record)
    panels.against_time(axes, t, tilt(chain, q), [f"link {k}" for k in range(1, chain.links + 1)], "link angle (rad)")
    axes.set_xlabel("t (s)")


@animate.register
def _(record: Trajectory, path: Path | str, *, seconds: float | None = None, fps: int = 25) -> Path:
    """The chain as it moves, with the path of its tip."""
    return write_motion(outline(record), record, Path(path), seconds, fps)


@animate.register
def _(record: Orbit, path: Path | str, *, seconds: float | None = None, fps: int = 25) -> Path:
    """One period, over and over: a small GIF or page; in `seconds`, at `fps` or as .mp4 as every motion is."""
    chain, suffix = outline(record), Path(path).suffix
    if seconds is None and suffix in (".gif", ".html"):
        write = animation.write_gif if suffix == ".gif" else animation.write_page
        return write(chain, record, path)
    return write_motion(chain, Played(f"{record.scene}: T = {record.period:.6g} s", record.t, record.q), Path(path), seconds, fps, record)


@animate.register
def _(record: Plan, path: Path | str, *, seconds: float | None = None, fps: int = 25) -> Path:
    """The chain as it was planned to move."""
    played = Played(f"{record.name}, as planned", record.t, record.x[:, : record.x.shape[1] // 2])
    return write_motion(outline(record), played, Path(path), seconds, fps, record)


@animate.register
def _(record: Connection, path: Path | str, *, seconds: float | None = None, fps: int = 25) -> Path:
    """The chain from one equilibrium to the other."""
    return write_motion(outline(record), Played(record.name, record.t, record.q), Path(path), seconds, fps, record)
