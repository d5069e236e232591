"""The Taylor flow as a Python callable: ``propagate(q, v, t, t_end, tol, ...)`` around NAME_propagate."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from phichain.errors import ArrayError, UnsupportedError
from phichain.native.arrays import REAL, SCALAR, address, flat_parameters
from phichain.native.flows.call import checked_tolerance, event_argument, finite, output_times, vector, wide
from phichain.native.signature import Argument, Signature
from phichain.system.propagation import OUTCOMES, Propagation, Stop

#: What NAME_propagate returns where a workspace is missing, and on which boundary a workspace is fastest.
_NO_WORKSPACE: Final = 4
_CACHE_LINE: Final = 64

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
    kind, number = REAL[real], SCALAR[REAL[real].name]
    flow_type = _flow_struct(number, nq + nv, variational)
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
        state_q, state_v = vector("propagate.q", q, nq, kind), vector("propagate.v", v, nv, kind)
        grid = output_times("propagate", times, t, t_end, kind)
        q_at, v_at = np.empty((len(grid), nq), kind), np.empty((len(grid), nv), kind)
        flow = flow_type(t=t, tolerance=checked_tolerance("propagate.tol", tol))
        if lost is not None:
            flow.t_lost, *flow.lost[:] = np.asarray(lost, dtype=float).tolist()
        carried = None
        if transition is not None:
            carried = _columns(transition, nq + nv, kind, variational)
            flow.transition, flow.columns = carried.ctypes.data, carried.shape[1]
        after = [vector("propagate.u", np.zeros(nu) if u is None else u, nu, kind)] if nu else []
        event = event_argument(stop, (nq, nv, links), number)
        before = flat_parameters(signature, p, kind)
        arguments = (
            *map(address, before), ctypes.byref(flow), number(t_end), ctypes.c_ulong(max_steps), *map(address, after),
            address(state_q), address(state_v), event, ctypes.c_ulong(len(grid)), address(grid), address(q_at), address(v_at),
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
            OUTCOMES[result], flow.t, wide(state_q), wide(state_v), wide(q_at[:reached]), wide(v_at[:reached]),
            flow.tolerance, flow.order, flow.steps, np.array([flow.t_lost, *flow.lost]),
            transition=None if carried is None else wide(carried),
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


def _room(flow: Any, size: int) -> NDArray[np.uint8] | None:
    """A workspace on cache lines for a scene that is too large for the stack; it lives as long as what is returned."""
    if not size:
        return None
    room = np.empty(size + _CACHE_LINE, np.uint8)
    flow.work = -(-room.ctypes.data // _CACHE_LINE) * _CACHE_LINE
    return room


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
    return finite("propagate.transition", array)
