"""Motions with losses: what comes to rest by dry friction, by every method that a user may take."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from mpmath import mp, mpf

from phichain import build
from phichain.motion import simulate
from phichain.scene import Scene
from phichain.system import System
from tests.losses.collocation import integrate
from tests.losses.dense import accelerations

STICKING = Scene("sticking", 1, base="cart", cart_mass=1.0, mass=0.5, length=0.7, friction=0.3, friction_speed=1e-3, cart_friction=1.5,
                 cart_friction_speed=1e-3, cart_damping=0.3, actuated="none",
                 want=("forward_dynamics", "state_jacobian", "energy", "propagate_stiff"))  # fmt: skip
START = np.array([0.0, 1.2, 0.5, -1.0])
#: The state after 2 s, by `integrate` on `dense.accelerations`, 36 digits, tolerance 1e-26.
AFTER = {1e-3: [0.349821989009394631664737, 0.0667125923833830774889743, 0.014139449249308057514443, -1.27157108277975504865125]}
BRAKED = Scene("braked_swing", 2, base="cart", cart_mass=1.3, cart_damping=0.4, mass=[0.7, 0.5], length=[0.6, 0.4], com=[0.3, 0.25],
               stiffness=[1.0, 0.5], rest_angle=[0.3, -0.4], damping=[0.02, 0.01], actuated="all", variational=True,
               want=("forward_dynamics", "energy", "propagate", "propagate_stiff", "propagate_batch", "step"))  # fmt: skip


def field(scene: Scene, u: tuple[float, ...] = ()):
    """x' by the dense Lagrangian."""
    return lambda x: [*x[scene.nq :], *accelerations(scene, x[: scene.nq], x[scene.nq :], u)]


@pytest.mark.parametrize("speed", sorted(AFTER))
def test_what_sticks_ends_right(speed: float) -> None:
    """The stiff flow is taken though nothing is stiff at the start, and ends where 36 digits do."""
    system = build(replace(STICKING, friction_speed=speed, cart_friction_speed=speed))
    for tol, most in ((1e-6, 1e-5), (1e-9, 1e-8), (1e-12, 1e-10)):
        found = simulate(system, START, [0.0, 2.0], tol=tol)
        assert found.method == "rosenbrock" and found.status == "complete"
        assert np.max(np.abs(found.x[-1] - AFTER[speed])) < most


def test_mild_friction_is_left_to_an_explicit_method() -> None:
    scene = replace(STICKING, friction_speed=0.1, cart_friction_speed=0.1)
    found = simulate(build(scene), START, [0.0, 0.5], tol=1e-11)
    with mp.workdps(20):
        right = integrate(field(scene), START, 0.5, mpf(10) ** -13, stages=4)
    assert found.method == "DOP853"
    assert np.max(np.abs(found.x[-1] - np.array([float(x) for x in right]))) < 1e-9


@pytest.fixture(scope="module")
def braked() -> System:
    return build(BRAKED)


def test_the_taylor_flow_of_a_braked_chain_is_the_motion_of_the_dense_lagrangian(braked: System) -> None:
    """Cart damper and springs that rest elsewhere, one at a time and many at once; the stiff flow to its tolerance."""
    x, u = np.array([0.1, 0.4, -0.9, 0.3, 1.0, -2.0]), np.array([0.5, 0.1, -0.2])
    with mp.workdps(24):
        right = np.array([float(y) for y in integrate(field(BRAKED, tuple(u)), x, 0.5, mpf(10) ** -18, stages=6)])
    q, v = x[:3], x[3:]
    found = braked.propagate(q, v, 0.0, 0.5, 1e-16, u=u)
    assert np.max(np.abs(np.append(found.q, found.v) - right)) < 1e-13
    many = braked.propagate_batch(*(np.tile(part[:, None], 5) for part in (q, v)), 0.0, 0.5, 1e-16, u=np.tile(u[:, None], 5))
    assert np.max(np.abs(np.vstack([many.q, many.v]) - right[:, None])) < 1e-13
    stiff = braked.propagate_stiff(q, v, 0.0, 0.5, 1e-10, u=u)
    assert np.max(np.abs(np.append(stiff.q, stiff.v) - right)) < 1e-8


def test_columns_are_the_differences_of_the_braked_flow(braked: System) -> None:
    x, h = np.array([0.1, 0.4, -0.9, 0.3, 1.0, -2.0]), 1e-4

    def end(y: np.ndarray) -> np.ndarray:
        found = braked.propagate(y[:3], y[3:], 0.0, 0.4, 1e-16, u=np.zeros(3))
        return np.append(found.q, found.v)

    found = braked.propagate(x[:3], x[3:], 0.0, 0.4, 1e-16, u=np.zeros(3), transition=np.eye(6)).transition
    units = h * np.eye(6)
    # Central differences of order 4.
    slopes = [(8 * (end(x + e) - end(x - e)) - (end(x + 2 * e) - end(x - 2 * e))) / (12 * h) for e in units]
    assert np.max(np.abs(found - np.array(slopes).T)) < 1e-9


def test_a_braked_spatial_cart_slows_down() -> None:
    """Links that hang still and a cart of mass m among them all: x' decays as exp(-d t / m) where no link swings."""
    scene = Scene("braked_trolley", 1, space="spatial", base="cart", cart_mass=2.0, cart_damping=1.5, mass=1e-12, length=0.5,
                  gravity=0.0, want=("forward_dynamics", "propagate", "propagate_batch", "propagate_stiff"))  # fmt: skip
    system = build(scene)
    q, v = np.array([0.0, 0.0, 0.0, 0.0, 1.0]), np.array([0.8, -0.4, 0.0, 0.0, 0.0])
    right = v[:2] * np.exp(-0.75 * 0.6)
    for name, tol in (("propagate", 1e-16), ("propagate_stiff", 1e-12)):
        found = system.function(name)(q, v, 0.0, 0.6, tol, u=np.zeros(2))
        assert np.max(np.abs(found.v[:2] - right)) < 1e-9
