"""Records as xarray Datasets: named axes, units, where they come from."""

from __future__ import annotations

import json
from functools import singledispatch
from importlib import import_module
from typing import Any

import numpy as np

from phichain.continuation import Branch
from phichain.control import Gains
from phichain.control.reach import Attraction, AttractionMap
from phichain.control.swing_up import Plan
from phichain.errors import UnsupportedError
from phichain.identification import Fit
from phichain.motion import Trajectory
from phichain.orbits import Network, Orbit
from phichain.orbits.connections import Connection
from phichain.orbits.forced.response import Response
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


@to_xarray.register
def _(record: Plan) -> Any:
    held = np.vstack([record.u, record.u[-1:]])
    data = {"x": (("t", "state"), record.x), "u": (("t", "input"), held)}
    return _dataset(record, data, {"t": ("t", record.t, {"units": "s"}), "state": list(record.state_names), "input": list(record.input_names)})


@to_xarray.register
def _(record: Connection) -> Any:
    data = {"q": (("t", "q_name"), record.q), "v": (("t", "v_name"), record.v)}
    return _dataset(record, data, {"t": ("t", record.t, {"units": "s"}), "q_name": list(record.q_names), "v_name": list(record.v_names)})


@to_xarray.register
def _(record: Response) -> Any:
    data: dict[str, Any] = {name: (("point", "name"), getattr(record, name)) for name in ("q", "v", "peak", "first")}
    data |= {"omega": ("point", record.omega, {"units": "rad/s"}), "stable": ("point", record.stable)}
    data |= {name: ("point", getattr(record, name)) for name in ("error", "residual")}
    return _dataset(record, data, {"arclength": ("point", record.arclength), "name": list(record.names)})


@to_xarray.register
def _(record: AttractionMap) -> Any:
    first, second = record.coordinates
    data = {"verdict": ((second, first), record.verdict), "time": ((second, first), record.time, {"units": "s"})}
    return _dataset(record, data, {first: record.axis, second: record.axis})


@to_xarray.register
def _(record: Attraction) -> Any:
    data = {name: ("equilibrium", getattr(record, name)) for name in ("radius", "beyond", "usual", "failed", "share", "runs")}
    return _dataset(record, data | {"s": (("equilibrium", "link"), record.s)}, {})


@to_xarray.register
def _(record: Fit) -> Any:
    data: dict[str, Any] = {name: (("t", "column"), getattr(record, name)) for name in ("measured", "fitted", "residual")}
    data |= {name: ("unknown", getattr(record, name)) for name in ("values", "standard_error")}
    data["correlation"] = (("unknown", "unknown_"), record.correlation)
    return _dataset(record, data, {"t": ("t", record.t, {"units": "s"}), "column": list(record.columns), "unknown": list(record.names)})


@to_xarray.register
def _(record: Network) -> Any:
    """A tree: one Dataset for each branch, which say what hangs on what by their numbers."""
    found = {f"branch_{k}": to_xarray(branch) for k, branch in enumerate(record.branches)}
    links = {str(k): vars(link) for k, link in enumerate(record.links)}
    root = _dataset(record, {}, {}).assign_attrs(_flat({"links": links}))
    return import_module("xarray").DataTree.from_dict({"/": root, **found})


def _dataset(record: Any, data: dict[str, Any], coordinates: dict[str, Any]) -> Any:
    try:
        import xarray
    except ImportError as failure:
        raise UnsupportedError("to_xarray", "xarray", "needs a package that is not installed", "pip install 'phichain[study]'") from failure
    return xarray.Dataset(data, coordinates, _flat(origin(record)))


def _flat(said: dict[str, Any]) -> dict[str, Any]:
    """Attributes as NetCDF and Zarr hold them: tables as one line of JSON each."""
    return {name: json.dumps(value) if isinstance(value, dict) else value for name, value in said.items()}
