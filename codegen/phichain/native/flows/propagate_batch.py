"""The batch flow as a Python callable: ``propagate_batch(q, v, t, t_end, tol, ...)`` around NAME_propagate_batch.

In Python the batch axis is first, in C it is last: arrays are transposed on the way.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from math import isfinite
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from phichain.contract.chain import Chain
from phichain.contract.flows import has_forcing
from phichain.errors import ArrayError
from phichain.native.flows.call import FlowCall, calls, event_argument, flow_call
from phichain.native.flows.checks import (
    checked_tolerance,
    demand_rounding,
    finite,
    forcing_of,
    own,
    step_budget,
)
from phichain.native.memory.arrays import address, converted
from phichain.native.memory.room import demand_room
from phichain.native.signature import Argument
from phichain.system.propagation import OUTCOMES, Stop
from phichain.system.propagation_batch import PropagationBatch
from phichain.system.threads import pieces, run

PropagateBatch = Callable[..., PropagationBatch]


@calls("propagate_batch")
def make_propagate_batch(chain: Chain, parameters: Sequence[Argument], function: Any) -> PropagateBatch:
    """Wrap NAME_propagate_batch.

    Args:
        chain: The scene.
        parameters: Its runtime parameters in the order of the C struct.
        function: The foreign function; its result type is set here.

    Returns:
        ``propagate_batch(q, v, t, t_end, tol, *, u, forcing, times, stop, max_steps, lost, p, workers) -> PropagationBatch``: from (q, v)
        of shapes (n, nq) and (n, nv) at times t to t_end, each one number or n; u, (nu,) or (n, nu), is held, `forcing` = (amplitude, omega),
        each one number or n, is A cos(omega t); `times`
        in the order of travel, the same for all; `workers` threads ($PHICHAIN_WORKERS, or one per core, when None), whose
        number changes no bit of the result.
    """
    nq, nv, nu = chain.nq, chain.nv, chain.nu
    call = flow_call("propagate_batch", chain, parameters, function)
    kind, work, is_forced = call.kind, _work(call), has_forcing(chain)
    none = np.empty(0, kind)

    def propagate_batch(
        q: ArrayLike,
        v: ArrayLike,
        t: ArrayLike,
        t_end: ArrayLike,
        tol: float,
        *,
        u: ArrayLike | None = None,
        forcing: Sequence[ArrayLike] | None = None,
        times: ArrayLike = (),
        stop: Stop | None = None,
        max_steps: int = 1_000_000,
        lost: ArrayLike | None = None,
        p: Mapping[str, Any] | None = None,
        workers: int | None = None,
    ) -> PropagationBatch:
        n, budget = _count(q), step_budget(call.name, max_steps)
        is_bare = isinstance(times, tuple) and not times
        wanted = none if is_bare else converted("propagate_batch.times", times, kind)
        demand_room("propagate_batch.q", n, (nq + nv) * (2 + wanted.size), kind)
        state_q, state_v = _columns("q", q, (n, nq), kind), _columns("v", v, (n, nv), kind)
        start, end = _each("t", t, n, kind), _each("t_end", t_end, n, kind)
        grid = none if is_bare else _times(np.atleast_1d(own("propagate_batch.times", wanted, kind)), start, end)
        kept = np.zeros((1 + nq + nv, n), kind) if lost is None else _columns("lost", lost, (n, 1 + nq + nv), kind)
        if lost is not None:
            demand_rounding("propagate_batch.lost", kept[0], end - start)
        q_at, v_at = (np.empty((len(grid), rows, n), kind) for rows in (nq, nv))
        if len(grid):
            q_at[:], v_at[:] = np.nan, np.nan
        steps, written = np.zeros(n, np.dtype("ulong")), np.zeros(n, np.dtype("ulong"))
        result, tolerance = np.zeros(n, np.intc), checked_tolerance("propagate_batch.tol", tol)
        given: dict[str, NDArray[Any]] = {"t_end": end}
        if nu:
            held = np.zeros(nu) if u is None else converted("propagate_batch.u", u, kind)
            given["u"] = _columns("u", np.broadcast_to(held, (n, nu)) if held.shape == (nu,) else held, (n, nu), kind)
        elif u is not None and np.size(u):
            raise ArrayError("propagate_batch.u", u, "is given to a chain that has no input", "leave u out, or actuate the scene")
        driven = forcing_of("propagate_batch", forcing, is_forced, kind)
        if driven is not None:
            given |= {name: _each(f"forcing ({name})", value, n, kind) for name, value in zip(("amplitude", "omega"), driven, strict=True)}
        event = event_argument(call, stop)
        changed = {
            "q": state_q, "v": state_v, "q_out": q_at, "v_out": v_at, "t": start, "lost": kept, "steps": steps, "written": written,
            "result": result,
        }  # fmt: skip
        flows: list[Any] = []

        def some(piece: slice) -> None:
            """Some of the trajectories."""
            is_all = piece.stop - piece.start == n
            own = changed | given if is_all else {name: _piece(array, piece) for name, array in (changed | given).items()}
            flow = call.carried(tolerance=tolerance, **{name: address(own[name]) for name in _CARRIED})
            values = {"n": piece.stop - piece.start, "flow": flow, "max_steps": budget, "count": len(grid), "times": grid}
            call({**values, **own, "event": event, "work": np.empty(work, kind)}, p)
            for name, array in () if is_all else changed.items():
                if not np.may_share_memory(own[name], array):
                    array[..., piece] = own[name]
            flows.append(flow)

        run([partial(some, piece) for piece in pieces(n, _LEAST, workers)], workers)
        flow = flows[0]
        return PropagationBatch.made(
            outcome=tuple(OUTCOMES[number] for number in result.tolist()), t=_fixed(start), q=_fixed(state_q.T), v=_fixed(state_v.T),
            q_at=_fixed(q_at.transpose(2, 0, 1)), v_at=_fixed(v_at.transpose(2, 0, 1)), tol=flow.tolerance, order=flow.order,
            steps=_fixed(steps, np.int64), written=_fixed(written, np.int64), lost=_fixed(kept.T), times=_fixed(grid),
        )  # fmt: skip

    return propagate_batch


_CARRIED: Final = ("t", "lost", "steps", "written", "result")
"""What the struct of the flow points to."""
_LEAST: Final = 32
"""Trajectories that are worth a thread; whole lanes of every kind of number."""


def _piece(array: NDArray[Any], piece: slice) -> NDArray[Any]:
    """Part of a component-major array as C takes it: the array's own memory where it lies in one piece."""
    return np.ascontiguousarray(array[..., piece])


def _work(call: FlowCall) -> int:
    """How many numbers the function works on: what it says when it is given none."""
    nothing = (convert(0) if isinstance(convert, type) else None for _, convert in call.takes)
    return int(call.function(*nothing))


def _fixed(array: NDArray[Any], kind: type[np.generic] = np.float64) -> NDArray[Any]:
    """An array of this call in rows, which nobody can write to any more."""
    rows = np.ascontiguousarray(array, dtype=kind)
    rows.setflags(write=False)
    return rows


def _count(q: ArrayLike) -> int:
    """Number of trajectories."""
    shape = converted("propagate_batch.q", q, np.dtype(float)).shape
    if len(shape) != 2 or shape[0] == 0:
        problem = "has no row per trajectory"
        raise ArrayError(
            "propagate_batch.q", shape, problem, "give shape (n, nq); use propagate for a single state"
        )
    return int(shape[0])


def _columns(name: str, value: ArrayLike, shape: tuple[int, int], kind: np.dtype[Any]) -> NDArray[Any]:
    """A component-major copy of finite rows that C may change."""
    array = own(f"propagate_batch.{name}", value, kind)
    if array.shape != shape:
        raise ArrayError(
            f"propagate_batch.{name}", array.shape, f"must have shape {shape}", "give a row per trajectory"
        )
    return finite(f"propagate_batch.{name}", array).T.copy()


def _each(name: str, value: ArrayLike, n: int, kind: np.dtype[Any]) -> NDArray[Any]:
    """One finite number per trajectory."""
    if type(value) is float and isfinite(value) and kind == np.float64:
        return np.full(n, value)
    array = own(f"propagate_batch.{name}", value, kind)
    if array.shape not in ((), (n,)):
        problem = f"must be one number or have shape ({n},)"
        raise ArrayError(f"propagate_batch.{name}", array.shape, problem, "give one number per trajectory")
    return np.broadcast_to(finite(f"propagate_batch.{name}", array, "give finite times"), (n,)).copy()


def _times(grid: NDArray[Any], start: NDArray[Any], end: NDArray[Any]) -> NDArray[Any]:
    if grid.ndim != 1:
        raise ArrayError("propagate_batch.times", grid.shape, "is no list of times", "give them one after the other")
    finite("propagate_batch.times", grid, "give finite times")
    if len(grid) == 0:
        return grid
    path = np.column_stack([start, np.broadcast_to(grid, (len(start), len(grid))), end])
    gaps = np.diff(path, axis=1)
    if not np.all(np.all(gaps >= 0, axis=1) | np.all(gaps <= 0, axis=1)):
        problem = "do not lie between t and t_end of every trajectory, in the order of travel"
        raise ArrayError("propagate_batch.times", grid, problem, "sort them")
    return grid
