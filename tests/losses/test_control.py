"""Gains of a cart that is braked, and what they are without its friction."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from phichain import build
from phichain.control import linearize, lqr
from phichain.errors import ControlError
from phichain.scene import Scene
from phichain.system import rhs_jacobian

RIG = Scene("braked_rig", 2, base="cart", angles="absolute", cart_mass=2.0, cart_damping=0.1, mass=0.2, length=0.6,
            want=("forward_dynamics", "linearization", "state_jacobian"))  # fmt: skip
WEIGHTS = {"Q": np.diag([1.0, 100.0, 100.0, 1.0, 10.0, 0.1]), "R": 0.1}


def test_gains_of_a_braked_cart() -> None:
    """Cart 2 kg with .1 N s/m, two masses of .2 kg on .6 m, both upright."""
    gains = lqr(build(RIG), (-1, -1), **WEIGHTS).K
    right = [3.16227766, 411.85064877, -493.3603324, 8.71695113, 27.82476306, -85.07905641]
    assert np.max(np.abs(gains - right)) < 1e-8


def test_gains_that_do_not_know_a_rough_rail_are_unstable_on_it() -> None:
    """The same regulator for a cart without friction leaves a strongly braked one falling; its own gains hold it."""
    rough = replace(RIG, cart_damping=40.0)
    A, B = linearize(build(rough), (-1, -1)).first_order
    ignorant, own = (lqr(build(scene), (-1, -1), **WEIGHTS).K for scene in (replace(RIG, cart_damping=None), rough))
    growth = [np.max(np.linalg.eigvals(A - B @ gains).real) for gains in (ignorant, own)]
    assert growth[0] > 0 > growth[1]


@pytest.mark.parametrize("angles", ["relative", "absolute", "adjacent"])
def test_the_linearisation_at_rest_is_the_jacobian_with_dry_friction(angles: str) -> None:
    """F tanh(v / v_0) is a damper F / v_0 there, at the joints and on the cart."""
    scene = replace(RIG, angles=angles, friction=[0.2, 0.3], friction_speed=0.01, cart_friction=0.7, cart_friction_speed=0.02,
                    stiffness=0.4, damping=0.1)  # fmt: skip
    system = build(scene)
    A = linearize(system, (1, 1)).first_order[0]
    exact = rhs_jacobian(system)(0.0, np.zeros(6))
    assert np.max(np.abs(A - exact)) < 1e-12 * np.max(np.abs(exact))
    D = linearize(system, (1, 1)).D
    assert D[0, 0] == pytest.approx(0.1 + 0.7 / 0.02, rel=1e-14) and not np.any(D[0, 1:])


def test_springs_that_rest_elsewhere_leave_no_vertical_target() -> None:
    system = build(replace(RIG, stiffness=1.0, rest_angle=[0.1, 0.0]))
    for signs in ((1, 1), (-1, -1)):
        with pytest.raises(ControlError, match="is no equilibrium"):
            lqr(system, signs)
