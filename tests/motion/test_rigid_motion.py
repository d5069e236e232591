"""Rigid links in motion and under control: the textbook's Acrobot, rods on carts, a wheel on a pendulum, flows of every kind."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from mpmath import mp, mpf
from scipy.integrate import solve_ivp
from scipy.linalg import solve_continuous_are

from phichain import build, simulate
from phichain.control import lqr
from phichain.fractional.factor import inertia_factor
from phichain.orbits.factored import factored_modes
from phichain.reference import reference
from phichain.reference.nudge import Nudge
from phichain.scene import Scene
from phichain.system import System
from tests.reference_cases import relative_error

FLOWS = ["forward_dynamics", "energy", "linearization", "propagate", "propagate_batch", "propagate_stiff", "step_variational"]


@pytest.fixture(scope="module")
def acrobot() -> System:
    return build(
        Scene("acrobot", 2, mass=1.0, length=1.0, com=0.5, inertia=1.0, gravity=9.8, actuated=[2], want=FLOWS)
    )


def test_acrobot_after_two_seconds(acrobot: System) -> None:
    """Against Spong's equations, integrated by a Runge-Kutta method of order 4 in 25 digits and extrapolated."""
    run = simulate(acrobot, [0.3, -0.2, 0.5, -1.0], 2.0, u=[1.0], tol=1e-13)
    assert np.allclose(np.cumsum(run.x[-1, :2]), [-0.00348556904748577, 0.0635330287670881], rtol=0, atol=1e-13)


@pytest.mark.parametrize("method", ["taylor", "rosenbrock"])
def test_flows_agree_with_scipy(acrobot: System, method: str) -> None:
    start, forward = np.array([0.3, -0.2, 0.5, -1.0]), acrobot.functions["forward_dynamics"]
    true = solve_ivp(
        lambda t, x: [*x[2:], *forward(x[:2], x[2:], np.array([1.0]))], (0, 1), start, "DOP853", rtol=1e-13, atol=1e-14
    )
    run = simulate(acrobot, start, 1.0, method, u=[1.0], tol=1e-11)
    assert np.allclose(run.x[-1], true.y[:, -1], rtol=0, atol=1e-9)


def cart_pole(states: np.ndarray, force: float, m: float, half: float, cart: float, g: float) -> tuple[float, float]:
    """Barto, Sutton and Anderson's cart-pole without friction, its pole a uniform rod of length 2 half, from the upright."""
    theta, rate = states
    push = (force + m * half * rate**2 * np.sin(theta)) / (cart + m)
    alpha = (g * np.sin(theta) - np.cos(theta) * push) / (half * (4 / 3 - m * np.cos(theta) ** 2 / (cart + m)))
    return push - m * half * alpha * np.cos(theta) / (cart + m), alpha


def test_rod_on_a_cart() -> None:
    """Their angle is counted from the upright, clockwise: phi = pi - theta."""
    rod, half, m, cart, g = 1.0, 0.5, 0.1, 1.0, 9.8
    keys: dict[str, Any] = {"base": "cart", "cart_mass": cart, "mass": m, "length": rod, "com": half, "gravity": g}
    system = build(Scene("rod_on_cart", 1, inertia=m * rod**2 / 12, want=["forward_dynamics", "linearization", "propagate"], **keys))
    forward = system.functions["forward_dynamics"]
    theta, rate, force = 0.3, -1.1, 2.0
    x, alpha = cart_pole(np.array([theta, rate]), force, m, half, cart, g)
    assert np.allclose(forward(np.array([0.0, np.pi - theta]), np.array([0.0, -rate]), np.array([force])), [x, -alpha], rtol=1e-14)
    run = simulate(system, [0.0, np.pi - theta, 0.0, -rate], 1.0, u=[force], tol=1e-13)

    def field(t: float, y: np.ndarray) -> list[float]:
        x, alpha = cart_pole(y[[1, 3]], force, m, half, cart, g)
        return [y[2], y[3], x, alpha]

    true = solve_ivp(field, (0, 1), [0.0, theta, 0.0, rate], "DOP853", rtol=1e-13, atol=1e-14).y[:, -1]
    assert np.allclose(run.x[-1], [true[0], np.pi - true[1], true[2], -true[3]], rtol=0, atol=1e-11)
    # Gains of the upright, from the cart-pole's own linearisation in (x, theta).
    over = half * (4 / 3 - m / (cart + m))
    a21, b2 = g / over, -1 / (cart + m) / over
    a, b = np.zeros((4, 4)), np.zeros((4, 1))
    a[:2, 2:], a[2, 1], a[3, 1] = np.eye(2), -m * half * a21 / (cart + m), a21
    b[2, 0], b[3, 0] = (1 - m * half * b2) / (cart + m), b2
    solved = solve_continuous_are(a, b, np.diag([1.0, 2.0, 3.0, 4.0]), np.eye(1))
    gains = (b.T @ solved)[0] * [1, -1, 1, -1]
    assert np.allclose(lqr(system, (-1,), [1.0, 2.0, 3.0, 4.0], 1.0).K[0], gains, rtol=1e-10)


def test_two_rods_on_a_cart() -> None:
    """The classical exercise: two uniform rods of 0.5 kg and 0.5 m on a cart of 1 kg."""
    rods: dict[str, Any] = {"mass": 0.5, "length": 0.5, "com": 0.25, "inertia": 0.5**3 / 12}
    scene = Scene(
        "rods_on_cart", 2, base="cart", cart_mass=1.0, gravity=9.8, angles="absolute", want=["linearization"], **rods
    )
    gains = lqr(build(scene), (-1, -1), [50.0, 50.0, 50.0, 20.0, 700.0, 700.0], 1.0)
    right = [7.07106781, 438.81392912, -556.47989845, 14.76770454, 4.82407542, -78.04248163]
    assert np.allclose(gains.K[0], right, rtol=0, atol=1e-8)


def test_wheel_at_the_tip_only_turns() -> None:
    """A reaction wheel: held at its centre of mass, it never feels gravity nor the link's motion, but for the torque."""
    keys: dict[str, Any] = {"mass": [0.3, 0.2], "length": [0.4, 0.1], "com": [0.2, 0.0], "inertia": [0.01, 0.004]}
    system = build(Scene("wheel", 2, angles="absolute", **keys, want=FLOWS[:-1]))
    run = simulate(system, [1.0, 0.3, 0.0, 5.0], 2.0, tol=1e-12)
    assert np.allclose(run.x[-1, 1], 0.3 + 5.0 * 2.0, atol=1e-10)
    moment = 0.3 * 0.2**2 + 0.01 + 0.2 * 0.4**2
    weight = 9.81 * (0.3 * 0.2 + 0.2 * 0.4)
    assert run.x[:, 0].min() < -0.9
    at = np.array([0.7, 0.0]), np.array([0.4, 2.0])
    assert np.allclose(system.functions["forward_dynamics"](*at), [-weight / moment * np.sin(0.7), 0.0], rtol=1e-14, atol=1e-15)


BODIES: dict[str, dict[str, Any]] = {
    "numbers": {"com": [0.25, 0.5], "inertia": [0.02, 0.01]},
    "runtime inertia": {"com": [0.25, 0.5], "inertia": "runtime"},
    "runtime wheel": {"com": "runtime", "inertia": "runtime"},
}


@pytest.mark.long
@pytest.mark.parametrize("method", ["taylor", "rosenbrock"])
@pytest.mark.parametrize("body", BODIES)
@pytest.mark.parametrize("space", ["planar", "spatial"])
def test_flows_of_rods_on_a_cart(space: str, body: str, method: str) -> None:
    """Against a Runge-Kutta method of order 8; the wheel's centre of mass is at its joint."""
    given = {name: value for name, value in {"com": [0.25, 0.0], "inertia": [0.02, 0.01]}.items() if BODIES[body][name] == "runtime"}
    flows = ["propagate_stiff"] if space == "spatial" and body == "runtime wheel" else ["propagate", "propagate_stiff"]
    if method == "taylor" and len(flows) == 1:
        method = "step_lie4"
    keys: dict[str, Any] = {"base": "cart", "cart_mass": 1.3, "mass": [0.5, 0.3], "length": [0.5, 0.4], "actuated": "none"}
    want = ["forward_dynamics", "step_lie4", *flows]
    system = build(Scene("rods_flow", 2, space=space, damping=0.01, want=want, **keys, **BODIES[body]))
    q, v = np.array([0.1, 0.7, -0.4]), np.array([0.0, 1.0, 2.0])
    if space == "spatial":
        q, v = np.array([0.1, 0.0, 0.6, 0.0, 0.8, 0.0, 0.6, 0.8]), np.array([0.0, 0.0, 0.8, 1.0, -0.6, 2.0, 0.8, -0.6])
    carts = system.cart_size

    def field(t: float, x: np.ndarray) -> np.ndarray:
        q, v = x[: system.nq], x[system.nq :]
        rate = v
        if space == "spatial":
            rate = np.append(v[:carts], np.cross(v[carts:].reshape(-1, 3), q[carts:].reshape(-1, 3)))
        return np.append(rate, system.functions["forward_dynamics"](q, v, **({"p": given} if given else {})))

    true = solve_ivp(field, (0, 0.5), np.append(q, v), "DOP853", rtol=1e-13, atol=1e-14).y[:, -1]
    more: dict[str, Any] = {"h": 1e-3} if method == "step_lie4" else {"tol": 1e-10}
    run = simulate(system, np.append(q, v), 0.5, method, p=given or None, **more)
    assert np.allclose(run.x[-1], true, rtol=0, atol=1e-8)


@pytest.mark.parametrize("space", ["planar", "spatial"])
def test_single_precision_over_decades(space: str) -> None:
    """Masses and lengths over four decades, a wheel among rods: 2e-6, or ten times what the rounding of the arguments does."""
    rng = np.random.default_rng(3)
    mass, length = (np.float32(10 ** rng.uniform(-2, 2, 4)).astype(float) for _ in range(2))
    com, spin = np.float32(length * [0.5, 1e-4, 1.5, 0.0]), np.float32(mass * length**2 / [12, 1e3, 2, 4])
    body = {"mass": mass.tolist(), "length": length.tolist(), "com": com.tolist(), "inertia": spin.tolist()}
    system = build(Scene("rods_float", 4, space=space, real="float", want=["forward_dynamics"], **body))
    scene = Scene("rods", 4, space=space, **body)
    q, v = rng.normal(size=(4, 3)), rng.normal(size=(4, 3))
    q /= np.linalg.norm(q, axis=1)[:, None]
    v -= q * np.sum(q * v, axis=1)[:, None]
    if space == "planar":
        q, v = q[:, 0], v[:, 0]
    q, v = np.float32(q).ravel(), np.float32(v).ravel()
    found = np.asarray(system.functions["forward_dynamics"](q, v), dtype=float)
    inputs = {"q": q.tolist(), "v": v.tolist()}
    true, moved = (reference(scene, "forward_dynamics", inputs, nudge=nudge)["a"] for nudge in (None, Nudge("1")))
    with mp.workdps(50):
        amplified = float(max(abs(a - b) for a, b in zip(true, moved, strict=True)) / max(map(abs, true)) * mpf(2) ** (80 - 24))
    assert relative_error(found.tolist(), true) < max(2e-6, 10 * amplified)


@pytest.mark.parametrize("base", ["fixed", "cart"])
def test_factor_of_the_inertia_matrix(base: str) -> None:
    keys: dict[str, Any] = {"base": "cart", "cart_mass": 1.3} if base == "cart" else {}
    rods: dict[str, Any] = {"mass": [0.5, 0.3], "length": [0.5, 0.4], "com": [0.25, 0.5], "inertia": "runtime"}
    system = build(Scene("rod_factor", 2, want=["mass_matrix"], **rods, **keys))
    q, p = np.linspace(0.3, 1.9, system.nq), {"inertia": [0.01, 0.3]}
    (factor,) = inertia_factor(system, q, p)
    assert np.allclose(factor.T @ factor, system.functions["mass_matrix"](q, p=p), rtol=1e-14, atol=1e-15)


@pytest.mark.parametrize("base", ["fixed", "cart"])
def test_modes_of_rods(base: str) -> None:
    """Of factors, against the eigenvalues of the linearisation."""
    keys: dict[str, Any] = {"base": "cart", "cart_mass": 1.3} if base == "cart" else {}
    rods: dict[str, Any] = {"mass": [0.5, 0.3, 0.2], "length": [0.5, 0.4, 0.7], "com": [0.25, 0.5, 0.35], "inertia": 0.01}
    system = build(Scene("rod_modes", 3, stiffness=[0.2, 0.1, 0.0], want=["linearization"], **rods, **keys))
    found = factored_modes(system)
    small = system.functions["linearization"](np.ones(3))
    squares = np.linalg.eigvals(np.linalg.solve(small[0], small[1])).real
    assert found is not None
    assert np.allclose(found[0], np.sqrt(np.sort(squares)[int(base == "cart") :]), rtol=1e-9)
