"""The results of a study as one xarray Dataset: the grid's axes and the samples as dimensions, named and with units."""

from __future__ import annotations

import json
from collections.abc import Mapping
from os import PathLike, fspath
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from phichain.errors import OutputError, StudyError
from phichain.studies.document import plan_of
from phichain.studies.plan import Plan
from phichain.studies.store import ABOUT, demand_same
from phichain.studies.task import PENDING, STATUS

if TYPE_CHECKING:
    import xarray as xr

_REPAIR: Final = "run the study again: it computes anew what cannot be read"


def open_study(path: str | PathLike[str], plan: Plan | None = None) -> xr.Dataset:
    """Results of a study from its store, in memory, in the order of its axes; what is not computed yet is NaN.

    Args:
        path: The store.
        plan: The study; the one that the store says it served last unless given.

    Raises:
        StudyError: The folder holds no study or another one, or a chunk of it cannot be read.
    """
    import xarray as xr
    import zarr

    path = Path(fspath(path))
    try:
        group: Any = zarr.open_group(path, mode="r")
        said: Any = group.attrs.asdict().get(ABOUT)
    except Exception as error:
        raise StudyError("out", str(path), "holds no study that can be read", "name the folder that a study wrote") from error
    if plan is None:
        if not isinstance(said, Mapping) or not isinstance(said.get("plan"), Mapping):
            raise StudyError("out", str(path), "holds no study", "name the folder that a study wrote")
        plan = plan_of(said["plan"])
    demand_same(path, said, plan)
    keys = _read(path, group, "key")
    place = {key.tobytes(): row for row, key in enumerate(keys)}
    rows = np.array([place.get(key.tobytes(), -1) for key in plan.point_keys()], dtype=np.int64)
    data: dict[str, Any] = {}
    for name in ("status", "failure", *plan.outputs):
        values = _in_order(_read(path, group, name), rows, plan, name)
        dims = (*plan.dims, *(group[name].metadata.dimension_names or ("task",))[1:])
        data[name] = (dims, values, {key: said for key, said in group[name].attrs.asdict().items() if key != "_FillValue"})
    return xr.Dataset(data, _coordinates(plan), {"phichain": _words(said), "plan": json.dumps(said["plan"])})


def _read(path: Path, group: Any, name: str) -> Any:
    try:
        return group[name][:]
    except Exception as error:
        raise StudyError("out", str(path), f"has a chunk of '{name}' that cannot be read", _REPAIR) from error


def _in_order(values: Any, rows: np.ndarray, plan: Plan, name: str) -> np.ndarray:
    """Values by task; what the store does not hold is filled."""
    fill: Any = PENDING if name == "status" else "" if name == "failure" else plan.outputs[name].dtype.type(255) if plan.outputs[name].meanings else np.nan
    found = np.full((len(rows), *values.shape[1:]), fill, dtype=values.dtype)
    held = rows >= 0
    found[held] = values[rows[held]]
    return found.reshape((*plan.shape, *values.shape[1:]))


def _coordinates(plan: Plan) -> dict[str, Any]:
    found: dict[str, Any] = {axis.key: np.array(axis.values) for axis in plan.grid}
    found |= {axis.key: ("sample", np.array(axis.values)) for axis in plan.samples}
    sizes = {dim: size for output in plan.outputs.values() for dim, size in output.dims.items()}
    return found | {dim: values for dim, values in plan.labels.items() if sizes.get(dim) == len(values)}


def _words(said: Any) -> str:
    """Where results come from, as one line that every format can hold."""
    return f"{said['format']}; phichain {said['version']}; study {said['study']}; task {said['task']}; scene {said['scene']} {said['digest']}"


def write_netcdf(dataset: xr.Dataset, path: str | PathLike[str]) -> Path:
    """Write results as NetCDF, which holds names without dots and brackets.

    Raises:
        OutputError: The file cannot be written.
    """
    target = Path(fspath(path))
    plain = {str(name): str(name).replace(".", "_").replace("[", "_").replace("]", "") for name in (*dataset.variables, *dataset.dims)}
    renamed = dataset.rename({old: new for old, new in plain.items() if old != new})
    try:
        renamed.to_netcdf(target, engine="scipy")
    except OSError as error:
        raise OutputError("netcdf", str(target), f"cannot be written, {error.strerror or error}", "name a file in a folder of your own") from error
    return target


def status_counts(status: np.ndarray) -> dict[str, int]:
    """How many tasks are pending, done and failed."""
    return {word: int(np.sum(status == code)) for code, word in enumerate(STATUS)}
