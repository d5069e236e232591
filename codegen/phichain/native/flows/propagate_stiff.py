"""The implicit flow as a Python callable: ``propagate_stiff(q, v, t, t_end, tol, ...)`` around NAME_propagate_stiff."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from phichain.contract.chain import Chain
from phichain.contract.rodas5p import ORDER
from phichain.native.flows.call import calls, flow_call
from phichain.native.flows.checks import checked_tolerance, demand_alone, vector
from phichain.native.flows.motion import Frames
from phichain.native.signature import Argument
from phichain.system.propagation import OUTCOMES, StiffPropagation

PropagateStiff = Callable[..., StiffPropagation]


@calls("propagate_stiff")
def make_propagate_stiff(chain: Chain, parameters: Sequence[Argument], function: Any) -> PropagateStiff:
    """Wrap NAME_propagate_stiff.

    Args:
        chain: The scene.
        parameters: Its runtime parameters in the order of the C struct.
        function: The foreign function; its result type is set here.

    Returns:
        ``propagate_stiff(q, v, t, t_end, tol, *, u, times, own, max_steps, lost, memory, p) -> StiffPropagation``: from
        (q, v) at time t to t_end, forwards or backwards; u is held; `times` in the order of travel, between t and
        t_end, or `own` for the ends of its own steps; `lost` and `memory` of an earlier result go on where it ended.
    """
    call = flow_call("propagate_stiff", chain, parameters, function)
    frames = Frames(call)

    def propagate_stiff(
        q: ArrayLike,
        v: ArrayLike,
        t: float,
        t_end: float,
        tol: float,
        *,
        u: ArrayLike | None = None,
        times: ArrayLike = (),
        own: bool = False,
        max_steps: int = 1_000_000,
        lost: ArrayLike | None = None,
        memory: tuple[float, float] | None = None,
        p: Mapping[str, Any] | None = None,
    ) -> StiffPropagation:
        frame = frames.take()
        t, t_end, budget = frame.begin(q, v, u, (t, t_end), max_steps, lost, p)
        flow = frame.flow
        flow.tolerance = checked_tolerance("propagate_stiff.tol", tol, 1e-10)
        if memory is not None:
            flow.step, flow.before = vector("propagate_stiff.memory", memory, 2, np.dtype(float)).tolist()
        if own:
            demand_alone(call.name, times)
        result, (t_at, q_at, v_at) = frame.own(budget) if own else frame.at(times, t, t_end, budget)
        found = StiffPropagation.made(
            outcome=OUTCOMES[result], **frame.reached(), q_at=q_at, v_at=v_at, t_at=t_at, order=ORDER, refused=frame.refused,
            memory=(flow.step, flow.before),
        )  # fmt: skip
        frames.give(frame)
        return found

    return propagate_stiff
