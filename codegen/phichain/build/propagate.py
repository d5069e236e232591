"""The Taylor flow as a Python callable: ``propagate(q, v, t, t_end, tol, ...)`` around NAME_propagate."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from math import isfinite
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from phichain.build.arrays import REAL, parameter_values
from phichain.build.signature import Argument, Signature
from phichain.errors import ArrayError, ToleranceError, UnsupportedError
from phichain.propagation import OUTCOMES, Propagation, Stop

#: What NAME_propagate returns where a workspace is missing, and on which boundary a workspace is fastest.
_NO_WORKSPACE: Final = 4
_CACHE_LINE: Final = 64

Vector = NDArray[np.float64]
Propagate = Callable[..., Propagation]


def make_propagate(
    name: str,
    sizes: tuple[int, int, int],
    links: int,
    parameters: Sequence[Argument],
    function: Any,
    real: str = "double",
    variational: bool = False,
) -> Propagate:
    """Wrap NAME_propagate.

    Args:
        name: Name of the scene.
        sizes: nq, nv and nu.
        links: Number of links.
        parameters: The scene's runtime parameters in the order of the C struct.
        function: The foreign function; its result type is set here.
        real: ``"double"`` or ``"float"``.
        variational: Whether the scene has the variational equations.

    Returns:
        ``propagate(q, v, t, t_end, tol, *, u, times, stop, max_steps, lost, transition, p) -> Propagation``: from
        (q, v) at time t to t_end, forwards or backwards; u is held; `times` in the order of travel, between t and
        t_end; `transition` (nq + nv, m) holds derivatives of (q, v) at t that are carried to where it ends, the
        identity for the whole state transition matrix.
    """
    nq, nv, nu = sizes
    kind, number = REAL[real], ctypes.c_double if real == "double" else ctypes.c_float
    flow_type, event_type = _flow_struct(number, nq + nv, variational), _event_struct(number)
    signature = Signature("propagate", f"{name}_propagate", (), (), tuple(parameters), bool(parameters))
    function.restype = ctypes.c_int
    workspace_bytes = 0

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
        transition: ArrayLike | None = None,
        p: Mapping[str, Any] | None = None,
    ) -> Propagation:
        nonlocal workspace_bytes
        state_q, state_v = _copied("q", q, nq, kind), _copied("v", v, nv, kind)
        grid = _times(times, t, t_end, kind)
        q_at, v_at = np.empty((len(grid), nq), kind), np.empty((len(grid), nv), kind)
        flow = flow_type(t=t, tolerance=checked_tolerance("propagate.tol", tol))
        if lost is not None:
            flow.t_lost, *flow.lost[:] = np.asarray(lost, dtype=float).tolist()
        carried = None
        if transition is not None:
            carried = _columns(transition, nq + nv, kind, variational)
            flow.transition, flow.columns = carried.ctypes.data, carried.shape[1]
        before, after = [], []
        if parameters:
            before.append(np.concatenate([np.ravel(field) for field in parameter_values(signature, p, kind)]))
        if nu:
            after.append(_copied("u", np.zeros(nu) if u is None else u, nu, kind))
        event = None
        if stop is not None:
            checked_index(stop, nq, nv, links)
            event = ctypes.byref(event_type(stop.number, stop.index, stop.value, stop.direction))
        arguments = (
            *map(_at, before), ctypes.byref(flow), number(t_end), ctypes.c_ulong(max_steps), *map(_at, after),
            _at(state_q), _at(state_v), event, ctypes.c_ulong(len(grid)), _at(grid), _at(q_at), _at(v_at),
        )  # fmt: skip
        room = _room(flow, workspace_bytes)
        result = function(*arguments)
        if result == _NO_WORKSPACE:
            workspace_bytes = flow.steps
            room = _room(flow, workspace_bytes)
            result = function(*arguments)
        del room
        reached = flow.written
        return Propagation(
            OUTCOMES[result], flow.t, _wide(state_q), _wide(state_v), _wide(q_at[:reached]), _wide(v_at[:reached]),
            flow.tolerance, flow.order, flow.steps, np.array([flow.t_lost, *flow.lost]),
            transition=None if carried is None else _wide(carried),
        )  # fmt: skip

    return propagate


@cache
def _flow_struct(number: type, size: int, variational: bool) -> type[ctypes.Structure]:
    """NAME_flow of the header."""
    fields = [
        ("t", number), ("tolerance", number), ("t_lost", number), ("lost", number * size),  # type: ignore[operator]
        *([("transition", ctypes.c_void_p), ("columns", ctypes.c_int)] if variational else []),
        ("work", ctypes.c_void_p), ("steps", ctypes.c_ulong), ("written", ctypes.c_ulong), ("order", ctypes.c_int),
    ]  # fmt: skip
    return type("Flow", (ctypes.Structure,), {"_fields_": fields})


@cache
def _event_struct(number: type) -> type[ctypes.Structure]:
    """NAME_event of the header."""
    fields = [
        ("scalar", ctypes.c_int),
        ("index", ctypes.c_int),
        ("value", number),
        ("direction", ctypes.c_int),
    ]
    return type("Event", (ctypes.Structure,), {"_fields_": fields})


def _room(flow: Any, size: int) -> NDArray[np.uint8] | None:
    """A workspace on cache lines for a scene that is too large for the stack; it lives as long as what is returned."""
    if not size:
        return None
    room = np.empty(size + _CACHE_LINE, np.uint8)
    flow.work = -(-room.ctypes.data // _CACHE_LINE) * _CACHE_LINE
    return room


def _at(array: NDArray[Any]) -> ctypes.c_void_p:
    # Five times as fast as array.ctypes, and a quarter period of a pendulum takes microseconds.
    return ctypes.c_void_p(array.__array_interface__["data"][0])


def _wide(array: NDArray[Any]) -> Vector:
    return array.astype(np.float64)


def _copied(name: str, value: ArrayLike, size: int, kind: np.dtype[Any]) -> NDArray[Any]:
    """A copy of a finite vector that C may change."""
    array = np.array(value, dtype=kind, order="C")
    if array.shape != (size,):
        raise ArrayError(f"propagate.{name}", array.shape, f"must have shape ({size},)", "give one vector")
    if not np.isfinite(array).all():
        raise ArrayError(f"propagate.{name}", array.tolist(), "is not finite", "give finite values")
    return array


def _columns(value: ArrayLike, size: int, kind: np.dtype[Any], variational: bool) -> NDArray[Any]:
    """A copy of columns of derivatives that C may change."""
    if not variational:
        raise UnsupportedError(
            "propagate.transition", np.shape(value), "asks for derivatives that the scene does not carry along",
            "set variational = true in its table [flow]",
        )  # fmt: skip
    array = np.array(value, dtype=kind, order="C")
    if array.ndim != 2 or array.shape[0] != size or not 1 <= array.shape[1] <= size:
        raise ArrayError(
            "propagate.transition", array.shape, f"must have shape ({size}, m), m from 1 to {size}",
            f"start with the identity, np.eye({size})",
        )  # fmt: skip
    if not np.all(np.isfinite(array)):
        raise ArrayError("propagate.transition", array.tolist(), "is not finite", "give finite values")
    return array


def _times(times: ArrayLike, t: float, t_end: float, kind: np.dtype[Any]) -> NDArray[Any]:
    grid = np.array(times, dtype=kind, order="C", ndmin=1)
    if not (isfinite(t) and isfinite(t_end) and np.all(np.isfinite(grid))):
        raise ArrayError("propagate.t", (t, t_end), "is not finite", "give finite times")
    if not grid.size:
        return grid
    path = np.concatenate([[t], grid, [t_end]])
    gaps = np.diff(path)
    if not (np.all(gaps >= 0) or np.all(gaps <= 0)):
        raise ArrayError(
            "propagate.times", grid, "do not lie between t and t_end in the order of travel", "sort them"
        )
    return grid


def checked_tolerance(field: str, tol: float) -> float:
    """The tolerance, if it is one."""
    if not (isfinite(tol) and tol > 0):
        raise ToleranceError(field, tol, "must be positive and finite", "use 1e-12")
    return tol


def checked_index(stop: Stop, nq: int, nv: int, links: int) -> None:
    """Refuse an event on an entry or a link that is not there."""
    limit = {"q": nq, "v": nv, "depth": links}[stop.scalar]
    if not 0 <= stop.index < limit:
        raise ArrayError("stop.index", stop.index, f"is not below {limit}", "count entries and links from 0")
