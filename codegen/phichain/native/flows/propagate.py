"""The Taylor flow as a Python callable: ``propagate(q, v, t, t_end, tol, ...)`` around NAME_propagate."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from phichain.contract.chain import Chain
from phichain.contract.flows import has_forcing
from phichain.errors import ArrayError, UnsupportedError
from phichain.native.flows.call import FlowCall, calls, event_argument, flow_call
from phichain.native.flows.checks import checked_tolerance, finite, forcing_of
from phichain.native.flows.checks import own as own_copy
from phichain.native.flows.motion import Frames, wide
from phichain.native.memory.arrays import place
from phichain.native.signature import Argument
from phichain.system.propagation import OUTCOMES, Propagation, Stop

Propagate = Callable[..., Propagation]


@calls("propagate")
def make_propagate(chain: Chain, parameters: Sequence[Argument], function: Any) -> Propagate:
    """Wrap NAME_propagate.

    Args:
        chain: The scene.
        parameters: Its runtime parameters in the order of the C struct.
        function: The foreign function; its result type is set here.

    Returns:
        ``propagate(q, v, t, t_end, tol, *, u, forcing, times, own, stop, max_steps, lost, transition, p) -> Propagation``: from
        (q, v) at time t to t_end, forwards or backwards; u is held, `forcing` = (amplitude, omega) of a forced scene is A cos(omega t); `times` in the order of travel, between t and
        t_end, or `own` for the ends of its own steps; `transition` (nq + nv, m) holds derivatives of (q, v) at t that are carried to where it ends, the
        identity for the whole state transition matrix.
    """
    call = flow_call("propagate", chain, parameters, function)
    is_variational, is_forced, frames = bool(chain.variational), has_forcing(chain), Frames(call)

    def propagate(
        q: ArrayLike,
        v: ArrayLike,
        t: float,
        t_end: float,
        tol: float,
        *,
        u: ArrayLike | None = None,
        forcing: Sequence[float] | None = None,
        times: ArrayLike = (),
        own: bool = False,
        stop: Stop | None = None,
        max_steps: int = 1_000_000,
        lost: ArrayLike | None = None,
        transition: ArrayLike | None = None,
        p: Mapping[str, Any] | None = None,
    ) -> Propagation:
        frame = frames.take()
        t, t_end, budget = frame.begin(q, v, u, (t, t_end), max_steps, lost, p)
        flow, carried = frame.flow, None
        flow.tolerance = checked_tolerance("propagate.tol", tol)
        if transition is not None:
            carried = _columns(transition, is_variational, call)
            flow.transition, flow.columns = place(carried), carried.shape[1]
        driven = forcing_of(call.name, forcing, is_forced, call.kind)
        if driven is not None:
            frame.force(*driven)
        event = event_argument(call, stop)
        frame.given["event"].value = event and ctypes.addressof(event)
        if own:
            _demand_alone(times)
        result, (t_at, q_at, v_at) = frame.own(budget) if own else frame.at(times, t, t_end, budget)
        matrix = None if carried is None else wide(carried)
        found = Propagation.made(
            outcome=OUTCOMES[result], **frame.reached(), q_at=q_at, v_at=v_at, t_at=t_at, order=flow.order, transition=matrix,
        )  # fmt: skip
        frames.give(frame)
        return found

    return propagate


def _demand_alone(times: ArrayLike) -> None:
    """Refuse times where the ends of the flow's own steps are asked for.

    Raises:
        ArrayError: There are some.
    """
    if np.size(times):
        problem = "are given, and so is own, which asks for the ends of the flow's own steps instead"
        raise ArrayError("propagate.times", times, problem, "leave one of them out")


def _columns(value: ArrayLike, is_variational: bool, call: FlowCall) -> NDArray[Any]:
    """A copy of columns of derivatives that C may change."""
    size = sum(call.sizes[:2])
    if not is_variational:
        raise UnsupportedError(
            "propagate.transition", np.shape(value), "asks for derivatives that the scene does not carry along",
            "set variational = true in its table [flow]",
        )  # fmt: skip
    array = own_copy("propagate.transition", value, call.kind)
    if array.ndim != 2 or array.shape[0] != size or not 1 <= array.shape[1] <= size:
        raise ArrayError(
            "propagate.transition", array.shape, f"must have shape ({size}, m), m from 1 to {size}",
            f"start with the identity, np.eye({size})",
        )  # fmt: skip
    return finite("propagate.transition", array)
