"""The implicit flow as a Python callable: ``propagate_stiff(q, v, t, t_end, tol, ...)`` around NAME_propagate_stiff."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from phichain.contract.rodas5p import ORDER
from phichain.native.arrays import REAL, SCALAR, address, flat_parameters
from phichain.native.flows.call import checked_tolerance, output_times, vector, wide
from phichain.native.signature import Argument, Signature
from phichain.system.propagation import OUTCOMES, StiffPropagation

PropagateStiff = Callable[..., StiffPropagation]


def make_propagate_stiff(
    name: str,
    sizes: tuple[int, int, int],
    parameters: Sequence[Argument],
    function: Any,
    real: str = "double",
) -> PropagateStiff:
    """Wrap NAME_propagate_stiff.

    Args:
        name: Name of the scene.
        sizes: nq, nv and nu.
        parameters: The scene's runtime parameters in the order of the C struct.
        function: The foreign function; its result type is set here.
        real: ``"double"`` or ``"float"``.

    Returns:
        ``propagate_stiff(q, v, t, t_end, tol, *, u, times, max_steps, lost, memory, p) -> StiffPropagation``: from
        (q, v) at time t to t_end, forwards or backwards; u is held; `times` in the order of travel, between t and
        t_end; `lost` and `memory` of an earlier result go on where it ended.
    """
    nq, nv, nu = sizes
    kind, number = REAL[real], SCALAR[REAL[real].name]
    flow_type = _flow_struct(number, nq + nv)
    signature = Signature(
        "propagate_stiff", f"{name}_propagate_stiff", (), (), tuple(parameters), bool(parameters)
    )
    function.restype = ctypes.c_int

    def propagate_stiff(
        q: ArrayLike,
        v: ArrayLike,
        t: float,
        t_end: float,
        tol: float,
        *,
        u: ArrayLike | None = None,
        times: ArrayLike = (),
        max_steps: int = 1_000_000,
        lost: ArrayLike | None = None,
        memory: tuple[float, float] | None = None,
        p: Mapping[str, Any] | None = None,
    ) -> StiffPropagation:
        state_q, state_v = vector("propagate_stiff.q", q, nq, kind), vector("propagate_stiff.v", v, nv, kind)
        grid = output_times("propagate_stiff", times, t, t_end, kind)
        q_at, v_at = np.empty((len(grid), nq), kind), np.empty((len(grid), nv), kind)
        flow = flow_type(t=t, tolerance=checked_tolerance("propagate_stiff.tol", tol, 1e-10))
        if lost is not None:
            flow.t_lost, *flow.lost[:] = np.asarray(lost, dtype=float).tolist()
        if memory is not None:
            flow.step, flow.before = memory
        after = [vector("propagate_stiff.u", np.zeros(nu) if u is None else u, nu, kind)] if nu else []
        before = flat_parameters(signature, p, kind)
        result = function(
            *map(address, before), ctypes.byref(flow), number(t_end), ctypes.c_ulong(max_steps), *map(address, after),
            address(state_q), address(state_v), ctypes.c_ulong(len(grid)), address(grid), address(q_at), address(v_at),
        )  # fmt: skip
        reached = flow.written
        return StiffPropagation(
            OUTCOMES[result], flow.t, wide(state_q), wide(state_v), wide(q_at[:reached]), wide(v_at[:reached]),
            flow.tolerance, ORDER, flow.steps, np.array([flow.t_lost, *flow.lost]), flow.refused,
            (flow.step, flow.before),
        )  # fmt: skip

    return propagate_stiff


@cache
def _flow_struct(number: type, size: int) -> type[ctypes.Structure]:
    """NAME_stiff of the header."""
    fields = [
        *((name, number) for name in ("t", "tolerance", "step", "before", "t_lost")),
        ("lost", number * size),  # type: ignore[operator]
        *((name, ctypes.c_ulong) for name in ("steps", "refused", "written")),
    ]
    return type("StiffFlow", (ctypes.Structure,), {"_fields_": fields})
