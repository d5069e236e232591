"""Built chains with rotors move as the Lagrangian written down by hand says, and are regulated as it says."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from phichain.control import lqr
from phichain.fractional import inertia_factor
from phichain.motion import simulate
from phichain.orbits import linear_modes
from phichain.pipeline import build
from phichain.scene import Scene
from phichain.system import System
from tests.control.test_control_regulator import exact_gains
from tests.handmade import planar

WANT = ("forward_dynamics", "energy", "mass_matrix", "linearization", "state_jacobian", "propagate", "propagate_stiff", "phi", "phi_jacobian")
CHAINS: dict[str, dict[str, Any]] = {
    "arm": {"mass": [1.0, 0.8], "length": [0.5, 0.4], "com": [0.25, 0.2], "armature": [0.6, 0.2], "stiffness": [0.5, 1.0]},
    "geared": {"mass": [1.0, 0.8, 0.5], "length": [0.5, 0.4, 0.3], "com": [0.2, 0.4, 0.1], "armature": [0.0, 50.0, 1e-3], "angles": "absolute"},
    "carted": {"mass": [0.3, 0.2], "length": [0.4, 0.3], "armature": [0.05, 0.0], "cart_mass": 0.7, "angles": "adjacent"},
    "single": {"mass": [0.7], "length": [0.5], "com": [0.3], "armature": [0.2]},
}  # fmt: skip


@cache
def pair(name: str) -> tuple[System, System]:
    """The built chain, and the same from its dense mass matrix."""
    keys = CHAINS[name]
    carted: dict[str, Any] = {"base": "cart", "actuated": "cart"} if "cart_mass" in keys else {"actuated": "all"}
    scene = Scene("rotors", len(keys["mass"]), want=WANT, **keys, **carted)
    by_hand = {key: value for key, value in keys.items() if key != "stiffness"}
    return build(scene), planar(**by_hand, stiffness=keys.get("stiffness"), actuated=carted["actuated"])


def start(system: System) -> np.ndarray:
    rng = np.random.default_rng(5)
    return np.concatenate([0.8 * rng.normal(size=system.nq), rng.normal(size=system.nv)])


@cache
def motion_by_hand(name: str) -> np.ndarray:
    """States after 0 .. 2 s, by DOP853 on the dense equations."""
    _, dense = pair(name)

    def field(t: float, x: np.ndarray) -> np.ndarray:
        q, v = np.split(x, 2)
        return np.concatenate([v, dense.forward_dynamics(q, v, np.zeros(dense.nu))])

    found = solve_ivp(field, (0.0, 2.0), start(dense), "DOP853", np.linspace(0, 2, 21), rtol=3e-14, atol=1e-14)
    return found.y.T


@pytest.mark.long
@pytest.mark.parametrize(("method", "most"), [("taylor", 1e-11), ("rosenbrock", 1e-8), ("DOP853", 1e-10)])
@pytest.mark.parametrize("name", CHAINS)
def test_motion(name: str, method: str, most: float) -> None:
    system, _ = pair(name)
    tol = 1e-15 if method == "taylor" else 1e-12
    run = simulate(system, start(system), np.linspace(0, 2, 21), method, tol)
    true = motion_by_hand(name)
    assert run.status == "complete"
    assert np.max(np.abs(run.x - true)) < most * np.max(np.abs(true))


@pytest.mark.parametrize(("name", "sign"), [("arm", 1), ("geared", -1), ("carted", -1)])
def test_gains(name: str, sign: int) -> None:
    """Those of the built chain, hanging or upright, against 40 digits of the linear equations written down by hand."""
    system, dense = pair(name)
    gains = lqr(system, [sign] * system.links)
    M, G, B = dense.linearization(np.full(system.links, float(sign)))
    n = len(M)
    A = np.block([[np.zeros((n, n)), np.eye(n)], [-np.linalg.solve(M, G), np.zeros((n, n))]])
    inputs = np.vstack([np.zeros((n, B.shape[1])), np.linalg.solve(M, B)])
    exact = exact_gains(A, inputs, gains.Q, gains.R)
    assert np.max(np.abs(gains.K - exact)) < 1e-10 * np.max(np.abs(exact))


@pytest.mark.parametrize("name", CHAINS)
def test_modes_and_fractional_factor(name: str) -> None:
    """Frequencies of small motions, and F^T F, from the mass matrix written down by hand."""
    system, dense = pair(name)
    M, G, *_ = dense.linearization(np.ones(system.links))
    squares = np.sort(np.linalg.eigvals(np.linalg.solve(M, G)).real)[system.cart_size :]
    assert linear_modes(system).omega == pytest.approx(np.sqrt(squares), rel=1e-9)
    q = start(system)[: system.nq]
    factor = inertia_factor(system, q)[0]
    assert factor.T @ factor == pytest.approx(dense.mass_matrix(q), rel=1e-13, abs=1e-13)
