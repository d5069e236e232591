"""How records show themselves: one line of a table for each kind of record, looked up by `phichain.records.Shown`."""

from __future__ import annotations

from collections.abc import Callable
from functools import singledispatch
from html import escape
from pathlib import Path
from typing import Any

import numpy as np

from phichain._version import __version__
from phichain.continuation import Branch
from phichain.control import Gains
from phichain.errors import UnsupportedError
from phichain.motion import Trajectory
from phichain.report import figures, panels
from phichain.report.geometry import outline
from phichain.report.moving import write_motion
from phichain.report.style import ACCENT, INK, SOFT, figure, look, png


@singledispatch
def plot(record: Any, ax: Any = None, **words: Any) -> Any:
    """Draw a record: on axes, or as a figure of its own.

    Raises:
        UnsupportedError: Nothing draws such a record.
    """
    raise UnsupportedError("plot", type(record).__name__, "has no picture", "draw its arrays by matplotlib")


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
def _(record: Branch, ax: Any = None) -> Any:
    """A family: its rate over every amplitude, folds marked; as a figure over its energy, too."""
    if ax is None:
        return figures.family(record)
    figures.against_amplitude(ax, record)
    return ax


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


@singledispatch
def animate(record: Any, path: Path | str, **words: Any) -> Path:
    """Write a record in motion.

    Raises:
        UnsupportedError: Nothing of it moves.
    """
    raise UnsupportedError("animate", type(record).__name__, "holds no motion", "animate the Trajectory of a simulation")


@animate.register
def _(record: Trajectory, path: Path | str, *, seconds: float | None = None, fps: int = 25) -> Path:
    """The chain as it moves, with the path of its tip."""
    return write_motion(outline(record), record, Path(path), seconds, fps)


@singledispatch
def to_xarray(record: Any) -> Any:
    """A record as named arrays.

    Raises:
        UnsupportedError: There are none of it.
    """
    raise UnsupportedError("to_xarray", type(record).__name__, "has no form with named axes", "use its arrays, or to_npz")


@to_xarray.register
def _(record: Trajectory) -> Any:
    data = {
        "q": (("t", "q_name"), record.q), "v": (("t", "v_name"), record.v), "a": (("t", "v_name"), record.a),
        "u": None if record.u is None else (("t", "u_name"), record.u),
        **{name: None if getattr(record, name) is None else ("t", getattr(record, name), {"units": units}) for name, units in _OVER_TIME.items()},
    }  # fmt: skip
    coordinates = {"t": ("t", record.t, {"units": "s"}), "q_name": list(record.q_names), "v_name": list(record.v_names)}
    if record.u is not None:
        coordinates["u_name"] = list(record.u_names)
    about = {"name": record.name, "digest": record.digest, "method": record.method, "status": record.status, "tol": record.tol, "reason": record.reason}
    return _dataset({name: value for name, value in data.items() if value is not None}, coordinates, about)


_OVER_TIME = {"kinetic": "J", "potential": "J", "work": "J", "loss": "J", "error": "1"}


@to_xarray.register
def _(record: Branch) -> Any:
    data: dict[str, Any] = {name: ("point", record.column(name)) for name in record.names}
    data |= {name: ("point", getattr(record, name)) for name in ("energy", "residual", "error") if getattr(record, name) is not None}
    about = {"name": record.name, "scene": record.scene, "digest": record.digest, "method": record.method, "mode": record.mode, "status": record.status, "reason": record.reason}
    return _dataset(data, {"arclength": ("point", record.arclength)}, about)


@to_xarray.register
def _(record: Gains) -> Any:
    data = {"K": (("input", "state"), record.K), "S": (("state", "state_"), record.S), "poles": ("pole", record.poles)}
    about = {"name": record.name, "digest": record.digest, "sample": record.sample, "residual": record.residual, "margin": record.margin}
    return _dataset(data, {"input": list(record.input_names), "state": list(record.state_names)}, about)


def _dataset(data: dict[str, Any], coordinates: dict[str, Any], about: dict[str, Any]) -> Any:
    try:
        import xarray
    except ImportError as failure:
        raise UnsupportedError("to_xarray", "xarray", "needs a package that is not installed", "pip install 'phichain[study]'") from failure
    return xarray.Dataset(data, coordinates, {"phichain": __version__, **about})


def html(record: Any) -> str:
    """What a notebook shows: what the record prints, and its picture where it can be drawn."""
    text = f"<pre>{escape(str(record))}</pre>"
    try:
        with look():
            picture = plot(record)
    except Exception:  # noqa: BLE001 - a notebook shows the words of what cannot be drawn, without matplotlib or without lengths
        return text
    from base64 import b64encode

    return f'{text}<img alt="{escape(repr(record))}" src="data:image/png;base64,{b64encode(png(picture)).decode()}">'
