"""Records as xarray Datasets: named axes, units, where they come from."""

from __future__ import annotations

from functools import singledispatch
from typing import Any

from phichain._version import __version__
from phichain.continuation import Branch
from phichain.control import Gains
from phichain.errors import UnsupportedError
from phichain.motion import Trajectory
from phichain.orbits import Orbit


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


@to_xarray.register
def _(record: Orbit) -> Any:
    data = {"q": (("t", "q_name"), record.q), "v": (("t", "v_name"), record.v)}
    about = {name: getattr(record, name) for name in ("scene", "digest", "method", "mode", "omega", "energy", "error", "closure")}
    return _dataset(data, {"t": ("t", record.t, {"units": "s"}), "q_name": list(record.q_names), "v_name": list(record.v_names)}, about)


def _dataset(data: dict[str, Any], coordinates: dict[str, Any], about: dict[str, Any]) -> Any:
    try:
        import xarray
    except ImportError as failure:
        raise UnsupportedError("to_xarray", "xarray", "needs a package that is not installed", "pip install 'phichain[study]'") from failure
    return xarray.Dataset(data, coordinates, {"phichain": __version__, **about})
