"""Frequency responses of chains whose base is forced, told where to be, or shaken: against linear equations, forces, and Mathieu's."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from phichain.orbits import respond
from phichain.pipeline import build
from phichain.scene import Scene


def test_a_cart_that_is_forced_has_no_multiplier_of_its_place() -> None:
    """Cart and link, small: (M - ..) by the linear equations; 2 N + 1 multipliers, and the cart's place is on nobody's mind."""
    system = build(Scene("pushed", 1, base="cart", mass=0.7, length=0.6, cart_mass=1.3, cart_damping=0.4, damping=0.02, want=("inverse_and_jacobian",)))
    found = respond(system, "cart", 1e-6, (3.0, 6.0), limits={"step_max": 0.5})
    w = found.omega
    mass = np.array([[2.0, 0.42], [0.42, 0.7 * 0.36]])
    for k in (0, len(w) // 2, len(w) - 1):
        dynamic = -(w[k] ** 2) * mass + 1j * w[k] * np.diag([0.4, 0.02]) + np.diag([0.0, 0.7 * 9.81 * 0.6])
        assert found.first[k] == pytest.approx(np.linalg.solve(dynamic, [1e-6, 0.0]), rel=1e-7)
    assert found.multipliers.shape[1] == 3 and np.all(found.stable) and "force on the cart" in found.place


def test_a_base_that_moves_is_a_force_on_the_masses() -> None:
    """theta'' = -(g / l) theta - b / l - ..: a base accelerated by B cos(w t) drives as -m l B cos(w t) does; as a told cart does."""
    base = build(Scene("moved", 1, base="moving", mass=0.7, length=0.6, damping=0.02, want=("inverse_and_jacobian",)))
    told = build(
        Scene(
            "told", 1, base="cart", drive="acceleration", mass=0.7, length=0.6, damping=0.02, want=("inverse_and_jacobian", "propagate"),
            variational=True, forced="cart",
        )
    )  # fmt: skip
    wall = build(Scene("held", 1, mass=0.7, length=0.6, damping=0.02, actuated="none", want=("inverse_and_jacobian",)))
    by_base, by_cart, by_torque = (
        respond(system, forced, amplitude, (3.0, 5.0))
        for system, forced, amplitude in ((base, "base", 0.5), (told, "cart", 0.5), (wall, 1, 0.5 * 0.7 * 0.6))
    )
    # A torque is no base: beyond small angles the lever m l cos(theta) is shorter.
    assert by_base.located("fold") and by_base.peak[0, 0] == pytest.approx(by_torque.peak[0, 0], rel=1e-2)
    for one, other in zip(by_base.events, by_cart.events, strict=True):
        assert one.kind == other.kind and one.omega == pytest.approx(other.omega, rel=1e-10)
        assert one.peak[0] == pytest.approx(other.peak[1], rel=1e-8)
    assert by_cart.peak[:, 0] == pytest.approx(0.5 / by_cart.omega**2, rel=1e-9)
    assert by_base.multipliers.shape[1] == by_cart.multipliers.shape[1] == 2
    shot = respond(told, None, 0.5, (3.0, 5.0), method="shooting")
    assert [event.omega for event in shot.events] == pytest.approx([event.omega for event in by_cart.events], rel=1e-9)
    assert shot.multipliers[0] == pytest.approx(by_cart.multipliers[0], abs=1e-7)


def test_a_base_shaken_up_and_down_doubles_the_period() -> None:
    """Hanging still is a motion; it loses stability where Mathieu's equation says, near w = 2 w_0."""
    system = build(Scene("shaken", 1, base="moving", mass=0.7, length=0.6, damping=0.01, want=("inverse_and_jacobian",)))
    found = respond(system, "base", 2.0, (6.0, 10.0), axis=2)
    assert np.max(found.peak) < 1e-12
    kinds = [event.kind for event in found.events]
    assert kinds == ["period doubling", "period doubling", "end of the range"]
    for event in found.located("period doubling"):
        # theta'' + d/(m l^2) theta' + (g - b cos(w t)) / l theta = 0 over one period, by another integrator.
        def rate(t, y, w=event.omega):
            return [y[1], -0.01 / (0.7 * 0.36) * y[1] - (9.81 - 2.0 * np.cos(w * t)) / 0.6 * y[0]]

        columns = [solve_ivp(rate, (0, 2 * np.pi / event.omega), x, "DOP853", rtol=1e-12, atol=1e-13).y[:, -1] for x in np.eye(2)]
        assert np.min(np.abs(np.linalg.eigvals(np.array(columns)) + 1)) < 1e-8
