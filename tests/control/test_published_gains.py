"""Gains that others have printed, to their digits: a cart with a rod of its own inertia and friction, continuous and sampled."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from phichain.control import lqr
from phichain.system import System
from tests.handmade import planar


@pytest.fixture(scope="module")
def tutorial() -> System:
    """The inverted pendulum of the Control Tutorials for MATLAB and Simulink (Messner, Tilbury), written down by hand."""
    cart, m, b, inertia, l, g = 0.5, 0.2, 0.1, 0.006, 0.3, 9.8
    M, G = np.array([[cart + m, -m * l], [-m * l, inertia + m * l**2]]), np.diag([0.0, -m * g * l])
    chain = planar([m], [2 * l], [l], cart_mass=cart, actuated="cart", leave_out=("forward_dynamics",))
    return replace(chain, functions={"linearization": lambda s: (M, G, np.diag([b, 0.0]), np.array([[1.0], [0.0]]))})


@pytest.mark.parametrize(
    ("weights", "sample", "printed"),
    [
        ((1, 1), None, (-1.0, -1.6567, 18.6854, 3.4594)),
        ((5000, 100), None, (-70.7107, -37.8345, 105.5298, 20.9238)),
        ((5000, 100), 0.01, (-61.9933, -33.5040, 95.0597, 18.8300)),
    ],
)
def test_the_tutorials_gains(tutorial: System, weights: tuple[float, float], sample: float | None, printed: tuple[float, ...]) -> None:
    """Printed in the order x, x', phi, phi'; Q weighs x and phi alone."""
    gains = lqr(tutorial, [-1], Q=[*weights, 0, 0], R=1, sample=sample)
    assert np.max(np.abs(gains.K[0, [0, 2, 1, 3]] - printed)) < 5.1e-5
