"""What the callables of the emitted flows have in common: states, times, events and parameters on their way to C."""

from __future__ import annotations

import ctypes
from functools import cache
from math import isfinite
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from phichain.errors import ArrayError, ToleranceError
from phichain.system.propagation import Stop


@cache
def event_struct(number: type) -> type[ctypes.Structure]:
    """NAME_event, or NAME_batch_event, of the header."""
    fields = [("scalar", ctypes.c_int), ("index", ctypes.c_int), ("value", number), ("direction", ctypes.c_int)]
    return type("Event", (ctypes.Structure,), {"_fields_": fields})


def event_argument(stop: Stop | None, sizes: tuple[int, int, int], number: type) -> Any:
    """The C argument for an event, None for none.

    Args:
        stop: the event.
        sizes: nq, nv and the number of links.
        number: the C type of its value.

    Raises:
        ArrayError: it is on an entry or a link that is not there.
    """
    if stop is None:
        return None
    limit = dict(zip(("q", "v", "depth"), sizes, strict=True))[stop.scalar]
    if not 0 <= stop.index < limit:
        raise ArrayError("stop.index", stop.index, f"is not below {limit}", "count entries and links from 0")
    return ctypes.byref(event_struct(number)(stop.number, stop.index, stop.value, stop.direction))


def vector(field: str, value: ArrayLike, size: int, kind: np.dtype[Any]) -> NDArray[Any]:
    """A copy of a finite vector that C may change.

    Raises:
        ArrayError: it has another shape, or is not finite.
    """
    array = np.array(value, dtype=kind, order="C")
    if array.shape != (size,):
        raise ArrayError(field, array.shape, f"must have shape ({size},)", "give one vector")
    return finite(field, array)


def finite(field: str, array: NDArray[Any], remedy: str = "give finite values") -> NDArray[Any]:
    """The array, if it is finite.

    Raises:
        ArrayError: it is not.
    """
    if not np.isfinite(array).all():
        raise ArrayError(field, array.tolist(), "is not finite", remedy)
    return array


def output_times(function: str, times: ArrayLike, t: float, t_end: float, kind: np.dtype[Any]) -> NDArray[Any]:
    """The times at which states are wanted, in the order of travel from t to t_end.

    Raises:
        ArrayError: a time is not finite, or they do not lie in that order.
    """
    grid = np.array(times, dtype=kind, order="C", ndmin=1)
    if not (isfinite(t) and isfinite(t_end) and np.isfinite(grid).all()):
        raise ArrayError(f"{function}.t", (t, t_end), "is not finite", "give finite times")
    if not grid.size:
        return grid
    gaps = np.diff(np.concatenate([[t], grid, [t_end]]))
    if not (np.all(gaps >= 0) or np.all(gaps <= 0)):
        problem = "do not lie between t and t_end in the order of travel"
        raise ArrayError(f"{function}.times", grid, problem, "sort them")
    return grid


def checked_tolerance(field: str, tol: float, usual: float = 1e-12) -> float:
    """The tolerance, if it is one.

    Raises:
        ToleranceError: it is not positive and finite.
    """
    if not (isfinite(tol) and tol > 0):
        raise ToleranceError(field, tol, "must be positive and finite", f"use {usual:g}")
    return tol


def wide(array: NDArray[Any]) -> NDArray[np.float64]:
    """A result in double precision, of its own."""
    return array.astype(np.float64)
