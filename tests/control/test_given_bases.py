"""Regulators of carts that steppers and velocity loops drive, and of moved bases; what refuses them."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import solve_continuous_are

from phichain import build
from phichain.control import computed_torque, controllability, equilibria, lqr
from phichain.errors import UnsupportedError
from phichain.fractional import inertia_spectrum
from phichain.orbits import linear_modes
from phichain.scene import Scene

G, L = 9.81, 0.4
WANT = ["forward_dynamics", "inverse_dynamics", "linearization", "mass_matrix", "energy"]
DRIVEN = Scene("driven_pole", 1, base="cart", drive="acceleration", mass=0.3, length=L, want=WANT)
MOVED = Scene("moved_pole", 1, base="moving", mass=0.3, length=L, want=WANT)


def by_hand(A: np.ndarray, B: np.ndarray, Q: np.ndarray, R: np.ndarray) -> np.ndarray:
    """Gains by SciPy's Riccati equation."""
    return np.linalg.solve(R, B.T @ solve_continuous_are(A, B, Q, R))


def test_cart_pole_by_acceleration() -> None:
    """Upright, theta = pi + delta: l delta'' = g delta + u, x'' = u; neither mass takes part."""
    A = np.zeros((4, 4))
    A[0, 2] = A[1, 3] = 1.0
    A[3, 1] = G / L
    B = np.array([[0.0], [0.0], [1.0], [1.0 / L]])
    Q, R = np.diag([10.0, 20.0, 1.0, 2.0]), np.array([[0.5]])
    gains = lqr(build(DRIVEN), Q=np.diag(Q), R=0.5)
    assert np.max(np.abs(gains.A - A)) < 1e-13 and np.max(np.abs(gains.B - B)) < 1e-14
    assert np.max(np.abs(gains.K - by_hand(A, B, Q, R))) < 1e-10 * np.max(np.abs(gains.K))
    law = gains.law()
    assert law.input_names == ("acceleration",) and law.input_units == ("m/s^2",)


def test_a_moved_base_steers_sideways_alone() -> None:
    """l delta'' = g delta + b_1 to first order; up and down is no lever there."""
    A, B = np.array([[0.0, 1.0], [G / L, 0.0]]), np.array([[0.0, 0.0], [1.0 / L, 0.0]])
    gains = lqr(build(MOVED), Q=1.0, R=2.0)
    assert np.max(np.abs(gains.B - B)) < 1e-14
    assert np.max(np.abs(gains.K - by_hand(A, B, np.eye(2), 2.0 * np.eye(2)))) < 1e-10 * np.max(np.abs(gains.K))
    assert not gains.K[1].any()
    assert gains.law().input_units == ("m/s^2", "m/s^2")


@pytest.mark.parametrize("angles", ["relative", "absolute"])
@pytest.mark.parametrize("base", ["cart", "moving"])
def test_linearization_is_the_slope_of_the_accelerations(base: str, angles: str) -> None:
    keys = {"drive": "acceleration", "cart_mass": 0.4} if base == "cart" else {}
    scene = Scene("slope", 3, base=base, mass=[0.3, 0.2, 0.4], length=[0.5, 0.4, 0.3], com=[0.3, 0.2, 0.1], angles=angles,
                  damping=0.05, actuated="all", want=[*WANT, "state_jacobian"], **keys)  # fmt: skip
    system = build(scene)
    for found in equilibria(system):
        gains_of = controllability(system, found.s)
        assert gains_of.is_controllable
        M, G_, D, B = system.linearization(np.array(found.s, float))
        dadq, dadv, dadu = system.state_jacobian(found.q, np.zeros(system.nv), np.zeros(system.nu))
        for slope, matrix in ((dadq, -G_), (dadv, -D), (dadu, B)):
            assert np.max(np.abs(M @ slope - matrix)) < 1e-12 * max(1.0, np.max(np.abs(matrix)))


def test_spatial_slopes() -> None:
    """In space along the rotations of the links: xi'' = omega' at a vertical chain."""
    for base, keys in (("cart", {"drive": "acceleration"}), ("moving", {})):
        scene = Scene("slope3", 2, "spatial", base, mass=[0.3, 0.2], length=[0.5, 0.4], com=[0.3, 0.1],
                      want=["forward_dynamics", "linearization"], **keys)  # fmt: skip
        system, width = build(scene), 1e-6
        for found in equilibria(system):
            M, _, B = system.linearization(np.array(found.s, float))
            carts = system.cart_size
            kept = [*range(carts), *(carts + 3 * k + i for k in range(2) for i in range(2))]
            for j in range(system.nu):
                u = width * np.eye(system.nu)[j]
                ends = [system.forward_dynamics(found.q, np.zeros(system.nv), way * u) for way in (1, -1)]
                slope = (ends[0] - ends[1])[kept] / (2 * width)
                assert np.max(np.abs(M @ slope - B[:, j])) < 1e-8


def test_what_asks_for_forces_refuses() -> None:
    system = build(DRIVEN)
    with pytest.raises(UnsupportedError, match="given its acceleration"):
        computed_torque(system, lambda t: (np.zeros(2), np.zeros(2), np.zeros(2)), 3.0)
    with pytest.raises(UnsupportedError, match="follows its input"):
        linear_modes(system)
    with pytest.raises(UnsupportedError, match="given its acceleration"):
        inertia_spectrum(system, np.zeros(2))
