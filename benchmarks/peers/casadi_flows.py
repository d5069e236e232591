"""CasADi's integrators on the chains of the tables: CVODES and its own collocation, right-hand side compiled."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from benchmarks.chains import Chain
from benchmarks.peers import recursions

Array = NDArray[np.float64]


def right_hand_side(chain: Chain) -> tuple[Any, Any]:
    """(x, x') in the scene's coordinates, an expert's recursion."""
    x = ca.SX.sym("x", chain.nq + chain.nv)
    entries = ca.vertsplit(x)
    q, v = entries[: chain.nq], entries[chain.nq :]
    moving = list(v)
    if chain.space == "spatial":
        for k in range(2, chain.nq, 3):
            moving[k : k + 3] = ca.vertsplit(ca.cross(ca.vertcat(*v[k : k + 3]), ca.vertcat(*q[k : k + 3])))
    return x, ca.vertcat(*moving, *recursions.accelerations(chain, recursions.forms(chain)[0], q, v, [], ca.sin, ca.cos))


def cvodes(chain: Chain, q: Array, v: Array, end: float, tolerance: float) -> Callable[[], Array]:
    """CVODES by Adams' formulas, functional iteration, compiled."""
    options = {
        "linear_multistep_method": "adams", "nonlinear_solver_iteration": "functional", "reltol": tolerance,
        "abstol": tolerance / 100, "max_num_steps": 100_000_000, "jit": True, "compiler": "shell",
        "jit_options": {"flags": ["-O3", "-march=native"]},
    }  # fmt: skip
    x, f = right_hand_side(chain)
    return _bound(ca.integrator("flow", "cvodes", {"x": x, "ode": f}, 0.0, end, options), chain, q, v)


def collocation(chain: Chain, q: Array, v: Array, end: float, degree: int, elements: int) -> Callable[[], Array]:
    """CasADi's collocation of a degree (Gauss-Legendre) on equal elements, Newton by its fast solver."""
    options = {
        "interpolation_order": degree, "collocation_scheme": "legendre", "number_of_finite_elements": elements,
        "rootfinder": "fast_newton", "rootfinder_options": {"abstol": 1e-14, "max_iter": 30},
    }  # fmt: skip
    x, f = right_hand_side(chain)
    return _bound(ca.integrator("flow", "collocation", {"x": x, "ode": f}, 0.0, end, options), chain, q, v)


def _bound(flow: Any, chain: Chain, q: Array, v: Array) -> Callable[[], Array]:
    start = ca.DM(np.concatenate([q, v]))
    return lambda: np.asarray(flow(x0=start)["xf"]).ravel()[: chain.nq]
