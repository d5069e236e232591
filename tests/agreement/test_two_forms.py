"""Paper B's (15) and (16)-(17), both emitted and compiled: one motion, said in unit vectors and in angular velocities."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from phichain.pipeline import build
from phichain.scene import Scene
from phichain.system import (
    System,
    angular_velocities,
    input_arguments,
    pack,
    rhs,
    unit_vectors,
    unpack,
    velocity,
)

WANT = ("forward_dynamics", "direction_dynamics", "energy")
STATES = 1000
CHAINS: Mapping[str, dict[str, Any]] = {
    "spherical pendulum": {"links": 1, "mass": 0.3, "length": 0.7},
    "double spherical pendulum": {"links": 2, "mass": [0.3, 0.5], "length": [0.7, 0.4]},
    "paper B": {"links": 5, "base": "cart", "mass": 0.1, "length": 0.1, "cart_mass": 0.5},
    "masses before the ends": {
        "links": 4, "base": "cart", "cart_mass": 0.5, "mass": [0.1, 0.4, 0.2, 0.3], "length": 0.2, "com": 0.1,
    },
    "springs and dampers": {
        "links": 3, "base": "cart", "cart_mass": 0.5, "mass": 0.2, "length": 0.3, "stiffness": 0.4, "damping": 0.02,
    },
    "loops": {"links": 24, "base": "cart", "mass": 0.1, "length": 0.1, "cart_mass": 0.5, "code": "loops"},
}  # fmt: skip


@pytest.fixture(scope="module")
def systems(tmp_path_factory: pytest.TempPathFactory) -> dict[str, System]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PHICHAIN_CACHE", str(tmp_path_factory.mktemp("cache") / "phichain"))
        return {
            name: build(Scene(f"form{k}", space="spatial", want=WANT, **keys))
            for k, (name, keys) in enumerate(CHAINS.items())
        }


def random_states(system: System, seed: int = 5) -> tuple[np.ndarray, np.ndarray]:
    """Unit directions and tangent angular velocities, (STATES, nq) and (STATES, nv)."""
    rng = np.random.default_rng(seed)
    q, v = rng.normal(size=(STATES, system.nq)), 3.0 * rng.normal(size=(STATES, system.nv))
    links, omega = unit_vectors(system, q), angular_velocities(system, v)
    links /= np.linalg.norm(links, axis=-1, keepdims=True)
    omega -= links * np.sum(links * omega, axis=-1, keepdims=True)
    return q, v


def second_derivative(system: System, q: np.ndarray, v: np.ndarray, a: np.ndarray) -> np.ndarray:
    """q'' = [x'', omega' x q + omega x (omega x q)], which is what (16)-(17) say of the directions."""
    links, omega, turning = (
        unit_vectors(system, q),
        angular_velocities(system, v),
        angular_velocities(system, a),
    )
    of_links = np.cross(turning, links) + np.cross(omega, np.cross(omega, links))
    return np.concatenate([a[..., : system.cart_size], of_links.reshape(*q.shape[:-1], -1)], axis=-1)


@pytest.mark.parametrize("name", CHAINS)
def test_15_is_16_and_17(systems: dict[str, System], name: str) -> None:
    system = systems[name]
    q, v = random_states(system)
    u = input_arguments(system, q, np.random.default_rng(6).normal(size=(STATES, 2)) if system.nu else None)
    found = system.direction_dynamics(q, velocity(system, q, v), *u)
    expected = second_derivative(system, q, v, system.forward_dynamics(q, v, *u))
    error = np.max(np.abs(found - expected), axis=1) / np.max(np.abs(expected), axis=1)
    assert found.shape == (STATES, system.nq) and np.max(error) < 3e-14


def test_the_spherical_pendulum(systems: dict[str, System]) -> None:
    """q'' = (g/l) (e_3 - (q.e_3) q) - |q'|^2 q, straight from Newton's law with the tension eliminated."""
    system = systems["spherical pendulum"]
    q, v = random_states(system)
    q_dot = velocity(system, q, v)
    expected = 9.81 / 0.7 * (np.eye(3)[2] - q[:, 2:] * q) - np.sum(q_dot**2, axis=1, keepdims=True) * q
    found = system.direction_dynamics(q, q_dot)
    np.testing.assert_allclose(found, expected, rtol=0, atol=2e-15 * np.max(np.abs(expected)))


@pytest.mark.parametrize("name", [name for name in CHAINS if name != "spherical pendulum"])
@pytest.mark.parametrize("form", ["forward_dynamics", "direction_dynamics"])
def test_a_vertical_plane_is_invariant(systems: dict[str, System], name: str, form: str) -> None:
    """Links, rates and the force in the e_1-e_3 plane: what leaves it is 0 in every bit; turned with the state otherwise."""
    system, rng = systems[name], np.random.default_rng(7)
    angle, rate = rng.uniform(-3, 3, (STATES, system.links)), rng.normal(size=(STATES, system.links))
    still = np.zeros_like(angle)
    q = np.stack([np.sin(angle), still, np.cos(angle)], axis=-1).reshape(STATES, -1)
    omega = np.stack([still, rate, still], axis=-1).reshape(STATES, -1)
    cart = np.array([[0.3, 0.0]] * STATES)[:, : system.cart_size]
    q, v = np.concatenate([cart, q], axis=1), np.concatenate([-cart, omega], axis=1)
    u = (cart,) if system.nu else ()
    rates = v if form == "forward_dynamics" else velocity(system, q, v)
    found = system.function(form)(q, rates, *u)
    parts, out_of_plane = unit_vectors(system, found), [0, 2] if form == "forward_dynamics" else [1]
    assert np.all(parts[..., out_of_plane] == 0) and np.all(found[:, 1 : system.cart_size] == 0)
    assert np.max(np.abs(parts)) > 1
    turn = np.array([[0.6, -0.8, 0.0], [0.8, 0.6, 0.0], [0.0, 0.0, 1.0]])
    again = system.function(form)(
        turned(system, turn, q), turned(system, turn, rates), *(x @ turn[:2, :2].T for x in u)
    )
    gap = np.max(np.abs(again - turned(system, turn, found)), axis=1)
    assert np.max(gap / np.max(np.abs(found), axis=1)) < 3e-14


def turned(system: System, turn: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Every vector of a batch turned about the vertical axis."""
    cart, links = values[..., : system.cart_size], unit_vectors(system, values)
    flat = (links @ turn.T).reshape(*values.shape[:-1], -1)
    return np.concatenate([cart @ turn[:2, :2].T[: system.cart_size, : system.cart_size], flat], axis=-1)


def test_one_motion_in_both_forms(systems: dict[str, System]) -> None:
    """The double spherical pendulum out of any plane, 2 s by (15) and by (16)-(17): the same curve and the same energy."""
    system = systems["double spherical pendulum"]
    states = random_states(system, seed=11)
    q, v = states[0][0], states[1][0] / 3

    def of_directions(t: float, x: np.ndarray) -> np.ndarray:
        directions, rates = x[: system.nq], x[system.nq :]
        return np.concatenate([rates, system.direction_dynamics(directions, rates)])

    keys: dict[str, Any] = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-12}
    one = solve_ivp(of_directions, (0.0, 2.0), np.concatenate([q, velocity(system, q, v)]), **keys).y[:, -1]
    two = solve_ivp(rhs(system), (0.0, 2.0), pack(q, v), **keys).y[:, -1]
    end, rates = unpack(system, two)
    np.testing.assert_allclose(one, np.concatenate([end, velocity(system, end, rates)]), rtol=0, atol=1e-8)
    omega = np.cross(unit_vectors(system, one[: system.nq]), one[system.nq :].reshape(-1, 3)).ravel()
    assert np.sum(system.energy(one[: system.nq], omega)) == pytest.approx(
        np.sum(system.energy(q, v)), abs=1e-10
    )
