"""The Taylor flow as a Python callable: ``propagate(q, v, t, t_end, tol, ...)`` around NAME_propagate."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from phichain.contract.chain import Chain
from phichain.contract.flows import NO_WORKSPACE
from phichain.errors import ArrayError, UnsupportedError
from phichain.native.flows.call import (
    FlowCall,
    calls,
    checked_tolerance,
    continued,
    event_argument,
    finite,
    flow_call,
    one_motion,
    own,
    reached,
    wide,
)
from phichain.native.signature import Argument
from phichain.system.propagation import Propagation, Stop

#: On which boundary a workspace is fastest.
_CACHE_LINE: Final = 64

Propagate = Callable[..., Propagation]


@calls("propagate")
def make_propagate(chain: Chain, parameters: Sequence[Argument], function: Any) -> Propagate:
    """Wrap NAME_propagate.

    Args:
        chain: The scene.
        parameters: Its runtime parameters in the order of the C struct.
        function: The foreign function; its result type is set here.

    Returns:
        ``propagate(q, v, t, t_end, tol, *, u, times, stop, max_steps, lost, transition, p) -> Propagation``: from
        (q, v) at time t to t_end, forwards or backwards; u is held; `times` in the order of travel, between t and
        t_end; `transition` (nq + nv, m) holds derivatives of (q, v) at t that are carried to where it ends, the
        identity for the whole state transition matrix.
    """
    call = flow_call("propagate", chain, parameters, function)
    is_variational, workspace_bytes = chain.variational, 0

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
        flow = call.carried()
        values = one_motion(call, q, v, u, (t, t_end), times, flow, max_steps)
        flow.tolerance = checked_tolerance("propagate.tol", tol)
        continued(call, flow, lost)
        carried = None
        if transition is not None:
            carried = _columns(transition, is_variational, call)
            flow.transition, flow.columns = carried.ctypes.data, carried.shape[1]
        values["event"] = event_argument(call, stop)
        room = _room(flow, workspace_bytes)
        result = call(values, p)
        if result == NO_WORKSPACE.number:
            workspace_bytes = flow.steps
            room = _room(flow, workspace_bytes)
            result = call(values, p)
        del room
        matrix = None if carried is None else wide(carried)
        return Propagation(**reached(values, result), order=flow.order, transition=matrix)

    return propagate


def _room(flow: Any, size: int) -> NDArray[np.uint8] | None:
    """A workspace on cache lines for a scene that is too large for the stack; it lives as long as what is returned."""
    if not size:
        return None
    room = np.empty(size + _CACHE_LINE, np.uint8)
    flow.work = -(-room.ctypes.data // _CACHE_LINE) * _CACHE_LINE
    return room


def _columns(value: ArrayLike, is_variational: bool, call: FlowCall) -> NDArray[Any]:
    """A copy of columns of derivatives that C may change."""
    size = sum(call.sizes[:2])
    if not is_variational:
        raise UnsupportedError(
            "propagate.transition", np.shape(value), "asks for derivatives that the scene does not carry along",
            "set variational = true in its table [flow]",
        )  # fmt: skip
    array = own("propagate.transition", value, call.kind)
    if array.ndim != 2 or array.shape[0] != size or not 1 <= array.shape[1] <= size:
        raise ArrayError(
            "propagate.transition", array.shape, f"must have shape ({size}, m), m from 1 to {size}",
            f"start with the identity, np.eye({size})",
        )  # fmt: skip
    return finite("propagate.transition", array)
