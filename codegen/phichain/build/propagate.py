"""The Taylor flow as a Python callable: ``propagate(q, v, t, t_end, tol, ...)`` around NAME_propagate."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from phichain.build.arrays import REAL, parameter_values
from phichain.build.signature import Argument, Signature
from phichain.errors import ArrayError, ToleranceError
from phichain.propagation import OUTCOMES, Propagation, Stop

Vector = NDArray[np.float64]
Propagate = Callable[..., Propagation]


def make_propagate(
    name: str,
    sizes: tuple[int, int, int],
    links: int,
    parameters: Sequence[Argument],
    function: Any,
    real: str = "double",
) -> Propagate:
    """Wrap NAME_propagate.

    Args:
        name: Name of the scene.
        sizes: nq, nv and nu.
        links: Number of links.
        parameters: The scene's runtime parameters in the order of the C struct.
        function: The foreign function; its result type is set here.
        real: ``"double"`` or ``"float"``.

    Returns:
        ``propagate(q, v, t, t_end, tol, *, u, times, stop, max_steps, lost, p) -> Propagation``: from (q, v) at
        time t to t_end, forwards or backwards; u is held; `times` in the order of travel, between t and t_end.
    """
    nq, nv, nu = sizes
    kind, number = REAL[real], ctypes.c_double if real == "double" else ctypes.c_float
    flow_type, event_type = _flow_struct(number, nq + nv), _event_struct(number)
    signature = Signature("propagate", f"{name}_propagate", (), (), tuple(parameters), bool(parameters))
    function.restype = ctypes.c_int

    def propagate(
        q: ArrayLike,
        v: ArrayLike,
        t: float,
        t_end: float,
        tol: float,
        *,
        u: ArrayLike | None = None,
        times: ArrayLike = (),
        stop: Stop | None = None,
        max_steps: int = 1_000_000,
        lost: ArrayLike | None = None,
        p: Mapping[str, Any] | None = None,
    ) -> Propagation:
        state_q, state_v = _copied("q", q, nq, kind), _copied("v", v, nv, kind)
        grid = _times(times, t, t_end, kind)
        q_at, v_at = np.empty((len(grid), nq), kind), np.empty((len(grid), nv), kind)
        flow = flow_type(t=t, tolerance=_tolerance(tol))
        if lost is not None:
            flow.t_lost, *flow.lost[:] = np.asarray(lost, dtype=float).tolist()
        before, after = [], []
        if parameters:
            before.append(np.concatenate([np.ravel(field) for field in parameter_values(signature, p, kind)]))
        if nu:
            after.append(_copied("u", np.zeros(nu) if u is None else u, nu, kind))
        event = None
        if stop is not None:
            _check_index(stop, nq, nv, links)
            event = ctypes.byref(event_type(stop.number, stop.index, stop.value, stop.direction))
        result = function(
            *map(_at, before), ctypes.byref(flow), number(t_end), ctypes.c_ulong(max_steps), *map(_at, after),
            _at(state_q), _at(state_v), event, ctypes.c_ulong(len(grid)), _at(grid), _at(q_at), _at(v_at),
        )  # fmt: skip
        reached = flow.written
        return Propagation(
            OUTCOMES[result], flow.t, _wide(state_q), _wide(state_v), _wide(q_at[:reached]), _wide(v_at[:reached]),
            flow.tolerance, flow.order, flow.steps, np.array([flow.t_lost, *flow.lost]),
        )  # fmt: skip

    return propagate


@cache
def _flow_struct(number: type, size: int) -> type[ctypes.Structure]:
    """NAME_flow of the header."""
    fields = [
        ("t", number), ("tolerance", number), ("t_lost", number), ("lost", number * size),  # type: ignore[operator]
        ("steps", ctypes.c_ulong), ("written", ctypes.c_ulong), ("order", ctypes.c_int),
    ]  # fmt: skip
    return type("Flow", (ctypes.Structure,), {"_fields_": fields})


@cache
def _event_struct(number: type) -> type[ctypes.Structure]:
    """NAME_event of the header."""
    fields = [("scalar", ctypes.c_int), ("index", ctypes.c_int), ("value", number), ("direction", ctypes.c_int)]
    return type("Event", (ctypes.Structure,), {"_fields_": fields})


def _at(array: NDArray[Any]) -> ctypes.c_void_p:
    return ctypes.c_void_p(array.ctypes.data)


def _wide(array: NDArray[Any]) -> Vector:
    return array.astype(np.float64)


def _copied(name: str, value: ArrayLike, size: int, kind: np.dtype[Any]) -> NDArray[Any]:
    """A copy of a finite vector that C may change."""
    array = np.array(value, dtype=kind, order="C")
    if array.shape != (size,):
        raise ArrayError(f"propagate.{name}", array.shape, f"must have shape ({size},)", "give one vector")
    if not np.all(np.isfinite(array)):
        raise ArrayError(f"propagate.{name}", array.tolist(), "is not finite", "give finite values")
    return array


def _times(times: ArrayLike, t: float, t_end: float, kind: np.dtype[Any]) -> NDArray[Any]:
    grid = np.array(times, dtype=kind, order="C", ndmin=1)
    if not (np.isfinite(t) and np.isfinite(t_end) and np.all(np.isfinite(grid))):
        raise ArrayError("propagate.t", (t, t_end), "is not finite", "give finite times")
    path = np.concatenate([[t], grid, [t_end]])
    gaps = np.diff(path)
    if not (np.all(gaps >= 0) or np.all(gaps <= 0)):
        raise ArrayError("propagate.times", grid, "do not lie between t and t_end in the order of travel", "sort them")
    return grid


def _tolerance(tol: float) -> float:
    if not (np.isfinite(tol) and tol > 0):
        raise ToleranceError("propagate.tol", tol, "must be positive and finite", "use 1e-12")
    return tol


def _check_index(stop: Stop, nq: int, nv: int, links: int) -> None:
    limit = {"q": nq, "v": nv, "depth": links}[stop.scalar]
    if not 0 <= stop.index < limit:
        raise ArrayError("stop.index", stop.index, f"is not below {limit}", "count entries and links from 0")
