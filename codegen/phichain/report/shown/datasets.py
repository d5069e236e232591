"""Records as xarray Datasets: named axes, units, where they come from."""

from __future__ import annotations

import json
from functools import singledispatch
from typing import Any

from phichain.continuation import Branch
from phichain.control import Gains
from phichain.errors import UnsupportedError
from phichain.motion import Trajectory
from phichain.orbits import Orbit
from phichain.origin import origin


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
    return _dataset(record, {name: value for name, value in data.items() if value is not None}, coordinates)


_OVER_TIME = {"kinetic": "J", "potential": "J", "work": "J", "loss": "J", "error": "1"}


@to_xarray.register
def _(record: Branch) -> Any:
    data: dict[str, Any] = {name: ("point", record.column(name)) for name in record.names}
    data |= {name: ("point", getattr(record, name)) for name in ("energy", "residual", "error") if getattr(record, name) is not None}
    return _dataset(record, data, {"arclength": ("point", record.arclength)})


@to_xarray.register
def _(record: Gains) -> Any:
    data = {"K": (("input", "state"), record.K), "S": (("state", "state_"), record.S), "poles": ("pole", record.poles)}
    return _dataset(record, data, {"input": list(record.input_names), "state": list(record.state_names)})


@to_xarray.register
def _(record: Orbit) -> Any:
    data = {"q": (("t", "q_name"), record.q), "v": (("t", "v_name"), record.v)}
    return _dataset(record, data, {"t": ("t", record.t, {"units": "s"}), "q_name": list(record.q_names), "v_name": list(record.v_names)})


def _dataset(record: Any, data: dict[str, Any], coordinates: dict[str, Any]) -> Any:
    try:
        import xarray
    except ImportError as failure:
        raise UnsupportedError("to_xarray", "xarray", "needs a package that is not installed", "pip install 'phichain[study]'") from failure
    return xarray.Dataset(data, coordinates, _flat(origin(record)))


def _flat(said: dict[str, Any]) -> dict[str, Any]:
    """Attributes as NetCDF and Zarr hold them: tables as one line of JSON each."""
    return {name: json.dumps(value) if isinstance(value, dict) else value for name, value in said.items()}
