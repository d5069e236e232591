"""heyoka's adaptive Taylor integrators on the motions of the tables: one trajectory, eight at a time, extended precision."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import heyoka as hy
import numpy as np
from numpy.typing import NDArray

from benchmarks.chains import Chain
from benchmarks.peers import recursions

Array = NDArray[np.float64]
Flow = Callable[[float], Array]


def system(chain: Chain, form: str) -> list[tuple[Any, Any]]:
    """(state, its rate) in the form's own coordinates.

    Args:
        chain: The chain, unforced.
        form: "link frame" (relative angles), "closed form" (absolute angles), "tension" (angular velocities) or
            "unit vectors" (their rates in place of angular velocities).
    """
    q, v = _symbols("q", chain.nq), _symbols("v", chain.nv)
    if form == "unit vectors":
        return [*zip(q, v, strict=True), *zip(v, recursions.spatial_tension_direct(chain, q, v, ()), strict=True)]
    if form == "closed form":
        found = recursions.planar.closed_form(chain, q, v, [], hy.sin, hy.cos)[1]
        return [*zip(q, v, strict=True), *zip(v, found, strict=True)]
    moving = list(v)
    if chain.space == "spatial":
        for k in range(2, chain.nq, 3):
            (a, b, c), (x, y, z) = v[k : k + 3], q[k : k + 3]
            moving[k : k + 3] = [b * z - c * y, c * x - a * z, a * y - b * x]
    found = recursions.accelerations(chain, form, q, v, [], hy.sin, hy.cos)
    return [*zip(q, moving, strict=True), *zip(v, found, strict=True)]


def state(chain: Chain, form: str, q: Array, v: Array) -> Array:
    """Rows (q, v) of the scene in the form's coordinates."""
    if form == "closed form":
        return np.hstack([np.cumsum(q, axis=-1), np.cumsum(v, axis=-1)])
    if form == "unit vectors":
        turned = v.copy()
        for k in range(2, chain.nq, 3):
            turned[..., k : k + 3] = np.cross(v[..., k : k + 3], q[..., k : k + 3])
        return np.hstack([q, turned])
    return np.hstack([q, v])


def configuration(chain: Chain, form: str, x: Array) -> Array:
    """q of the scene from rows of the form's state."""
    q = x[..., : chain.nq]
    return np.diff(q, prepend=0.0, axis=-1) if form == "closed form" else q


def integrator(chain: Chain, form: str, q: Array, v: Array, tolerance: float) -> tuple[Any, Array]:
    """heyoka's own object without compact mode, and its state at the start."""
    start = state(chain, form, q, v)
    return hy.taylor_adaptive(system(chain, form), start.copy(), tol=tolerance, compact_mode=False), start


def one(chain: Chain, form: str, compact: bool, q: Array, v: Array, tolerance: float) -> Flow:
    """A propagation of one state to a time; returns the scene's q there."""
    start = state(chain, form, q, v)
    flow = hy.taylor_adaptive(system(chain, form), start.copy(), tol=tolerance, compact_mode=compact)

    def run(t: float) -> Array:
        flow.time = 0.0
        flow.state[:] = start
        flow.propagate_until(t)
        return configuration(chain, form, np.array(flow.state))

    return run


def batch(chain: Chain, form: str, compact: bool, q: Array, v: Array, tolerance: float) -> Flow:
    """The same of as many states as there are rows, side by side."""
    start = np.ascontiguousarray(state(chain, form, q, v).T)
    flow = hy.taylor_adaptive_batch(system(chain, form), start.copy(), tol=tolerance, compact_mode=compact)

    def run(t: float) -> Array:
        flow.set_time(0.0)
        flow.state[:] = start
        flow.propagate_until(t)
        return configuration(chain, form, np.array(flow.state).T)

    return run


def columns(chain: Chain, q: Array, v: Array, tolerance: float, compact: bool) -> Flow:
    """One state with the whole state transition matrix (variational equations of order 1)."""
    form = "link frame" if chain.space == "planar" else "tension"
    variational = hy.var_ode_sys(system(chain, form), hy.var_args.vars, order=1)
    flow = hy.taylor_adaptive(variational, state(chain, form, q, v).tolist(), tol=tolerance, compact_mode=compact)
    start = np.array(flow.state)

    def run(t: float) -> Array:
        flow.time = 0.0
        flow.state[:] = start
        flow.propagate_until(t)
        size = chain.nq + chain.nv
        return np.array(flow.state)[size:].reshape(size, size)

    return run


def event(chain: Chain, q: Array, v: Array, tolerance: float) -> Callable[[], float]:
    """When the first angle first passes zero, s."""
    equations = system(chain, "link frame")
    stop = hy.t_event(equations[0][0])
    start = state(chain, "link frame", q, v)
    flow = hy.taylor_adaptive(equations, start.copy(), tol=tolerance, t_events=[stop])

    def run() -> float:
        flow.time = 0.0
        flow.state[:] = start
        flow.reset_cooldowns()
        flow.propagate_until(100.0)
        return float(flow.time)

    return run


def extended(chain: Chain, form: str, q: Array, v: Array, t: float) -> list[str]:
    """q of one trajectory from 80-bit arithmetic at 1e-18, as decimal strings."""
    start = state(chain, form, np.array(q, dtype=np.longdouble), np.array(v, dtype=np.longdouble))
    flow = hy.taylor_adaptive(
        system(chain, form), start, tol=np.longdouble(1e-18), fp_type=np.longdouble, compact_mode=True
    )
    flow.propagate_until(np.longdouble(t))
    return [np.format_float_scientific(x, precision=20) for x in configuration(chain, form, np.array(flow.state))]


def _symbols(name: str, count: int) -> list[Any]:
    found = hy.make_vars(*(f"{name}_{k}" for k in range(count)))
    return [found] if count == 1 else list(found)
