"""The implicit flow as a Python callable: ``propagate_stiff(q, v, t, t_end, tol, ...)`` around NAME_propagate_stiff."""

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
from phichain.propagation import OUTCOMES, StiffPropagation
from phichain.rosenbrock_tableau import ORDER

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
    kind, number = REAL[real], ctypes.c_double if real == "double" else ctypes.c_float
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
        state_q, state_v = _copied("q", q, nq, kind), _copied("v", v, nv, kind)
        grid = _times(times, t, t_end, kind)
        q_at, v_at = np.empty((len(grid), nq), kind), np.empty((len(grid), nv), kind)
        flow = flow_type(t=t, tolerance=_tolerance(tol))
        if lost is not None:
            flow.t_lost, *flow.lost[:] = np.asarray(lost, dtype=float).tolist()
        if memory is not None:
            flow.step, flow.before = memory
        before, after = [], []
        if parameters:
            before.append(np.concatenate([np.ravel(field) for field in parameter_values(signature, p, kind)]))
        if nu:
            after.append(_copied("u", np.zeros(nu) if u is None else u, nu, kind))
        result = function(
            *map(_at, before), ctypes.byref(flow), number(t_end), ctypes.c_ulong(max_steps), *map(_at, after),
            _at(state_q), _at(state_v), ctypes.c_ulong(len(grid)), _at(grid), _at(q_at), _at(v_at),
        )  # fmt: skip
        reached = flow.written
        return StiffPropagation(
            OUTCOMES[result], flow.t, _wide(state_q), _wide(state_v), _wide(q_at[:reached]), _wide(v_at[:reached]),
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


def _at(array: NDArray[Any]) -> ctypes.c_void_p:
    return ctypes.c_void_p(array.ctypes.data)


def _wide(array: NDArray[Any]) -> NDArray[np.float64]:
    return array.astype(np.float64)


def _copied(name: str, value: ArrayLike, size: int, kind: np.dtype[Any]) -> NDArray[Any]:
    """A copy of a finite vector that C may change."""
    array = np.array(value, dtype=kind, order="C")
    if array.shape != (size,):
        raise ArrayError(
            f"propagate_stiff.{name}", array.shape, f"must have shape ({size},)", "give one vector"
        )
    if not np.all(np.isfinite(array)):
        raise ArrayError(f"propagate_stiff.{name}", array.tolist(), "is not finite", "give finite values")
    return array


def _times(times: ArrayLike, t: float, t_end: float, kind: np.dtype[Any]) -> NDArray[Any]:
    grid = np.array(times, dtype=kind, order="C", ndmin=1)
    if not (np.isfinite(t) and np.isfinite(t_end) and np.all(np.isfinite(grid))):
        raise ArrayError("propagate_stiff.t", (t, t_end), "is not finite", "give finite times")
    gaps = np.diff(np.concatenate([[t], grid, [t_end]]))
    if not (np.all(gaps >= 0) or np.all(gaps <= 0)):
        remedy, problem = "sort them", "do not lie between t and t_end in the order of travel"
        raise ArrayError("propagate_stiff.times", grid, problem, remedy)
    return grid


def _tolerance(tol: float) -> float:
    if not (np.isfinite(tol) and tol > 0):
        raise ToleranceError("propagate_stiff.tol", tol, "must be positive and finite", "use 1e-10")
    return tol
