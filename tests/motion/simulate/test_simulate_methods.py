"""Every integrator against motions known in closed form."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.special import ellipj, ellipk

from phichain.errors import UnsupportedError
from phichain.motion import Event, simulate
from phichain.system import System
from tests.handmade import GRAVITY, planar, spatial, uniform_planar

LENGTH = 0.7
OMEGA_0 = np.sqrt(GRAVITY / LENGTH)
ADAPTIVE = ("auto", "DOP853", "RK45", "Radau", "BDF", "LSODA", "cvodes", "cvodes_adams", "idas")


def pendulum_dynamics():
    casadi = pytest.importorskip("casadi")
    q, v = casadi.SX.sym("q"), casadi.SX.sym("v")
    return casadi.Function("forward_dynamics", [q, v], [-GRAVITY / LENGTH * casadi.sin(q)], ["q", "v"], ["a"])


def pendulum(with_casadi: bool = False) -> System:
    system = planar([1.3], [LENGTH])
    if not with_casadi:
        return system
    functions = {**system.functions, "casadi": pendulum_dynamics()}
    return System(**{**system.__dict__, "functions": functions})


def exact_angle(t: np.ndarray, amplitude: float) -> np.ndarray:
    """theta(t) of a pendulum released from rest at `amplitude`: Jacobi's elliptic functions."""
    k = np.sin(amplitude / 2)
    sn, _, dn, _ = ellipj(ellipk(k**2) - OMEGA_0 * t, k**2)
    return 2 * np.arcsin(k * sn) + 0 * dn


@pytest.mark.parametrize("method", ADAPTIVE)
def test_pendulum_against_elliptic_functions(method: str) -> None:
    system = pendulum(with_casadi=method in ("cvodes", "cvodes_adams", "idas"))
    loose, tight = (simulate(system, [2.0, 0.0], np.linspace(0, 3, 31), method, tol) for tol in (1e-5, 1e-8))
    errors = [np.max(np.abs(run.q[:, 0] - exact_angle(run.t, 2.0))) for run in (loose, tight)]
    assert errors[1] < 2e-6
    assert errors[1] < 0.1 * errors[0]
    assert tight.status == "complete" and tight.counts["steps"] > loose.counts["steps"]


def test_auto_reaches_its_tolerance() -> None:
    for tol in (1e-6, 1e-9, 1e-12):
        run = simulate(pendulum(), [2.0, 0.0], np.linspace(0, 3, 31), tol=tol)
        assert np.max(np.abs(run.q[:, 0] - exact_angle(run.t, 2.0))) < tol


def test_step_has_order_four() -> None:
    errors = []
    for h in (0.02, 0.01, 0.005):
        run = simulate(pendulum(), [1.0, 0.0], [0.0, 2.0], "step", h=h)
        errors.append(abs(run.q[-1, 0] - exact_angle(run.t[-1], 1.0)))
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert np.all(np.abs(orders - 4) < 0.1)


def test_step_lands_on_every_output_and_keeps_h() -> None:
    times = np.array([0.0, 0.013, 0.1, 0.137])
    run = simulate(pendulum(), [1.0, 0.0], times, "step", h=0.01)
    assert np.array_equal(run.t, times)
    assert run.counts["steps"] == 2 + 9 + 4
    assert np.isnan(run.tol)


def test_a_named_step_is_looked_up() -> None:
    system = pendulum()
    renamed = System(
        **{**system.__dict__, "functions": {**system.functions, "step_other": system.functions["step"]}}
    )
    plain = simulate(renamed, [1.0, 0.0], 1.0, "step", h=0.01)
    other = simulate(renamed, [1.0, 0.0], 1.0, "step_other", h=0.01)
    assert np.array_equal(plain.q, other.q) and other.method == "step_other"
    with pytest.raises(UnsupportedError, match="step_lie4"):
        simulate(renamed, [1.0, 0.0], 1.0, "step_lie4", h=0.01)


@pytest.mark.long
@pytest.mark.parametrize("method", ["DOP853", "Radau", "step"])
def test_conical_pendulum_turns_steadily(method: str) -> None:
    """A spherical pendulum on a cone turns at sqrt(g / (l cos alpha)) and keeps its height."""
    alpha = 0.6
    turn = np.sqrt(GRAVITY / (0.5 * np.cos(alpha)))
    q0 = np.array([np.sin(alpha), 0.0, np.cos(alpha)])
    omega0 = turn * (np.array([0.0, 0.0, 1.0]) - np.cos(alpha) * q0)
    run = simulate(spatial([0.4], [0.5]), (q0, omega0), np.linspace(0, 2, 9), method, 1e-10, h=2e-3)
    expected = [
        np.sin(alpha) * np.cos(turn * run.t),
        np.sin(alpha) * np.sin(turn * run.t),
        0 * run.t + np.cos(alpha),
    ]
    assert np.max(np.abs(run.q - np.transpose(expected))) < 1e-7
    assert np.max(np.abs(run.length_error)) < 1e-9 and np.max(np.abs(run.tangency_error)) < 1e-7


def test_constant_force_on_a_cart_gives_linear_momentum() -> None:
    system = planar([0.3, 0.2], [0.5, 0.4], cart_mass=1.1, actuated="cart")
    run = simulate(system, [0, 0.4, -0.3, 0, 0, 0], np.linspace(0, 2, 5), u=[0.7])
    phi, phi_dot = np.cumsum(run.q[:, 1:], axis=1), np.cumsum(run.v[:, 1:], axis=1)
    mu = np.array([0.5 * 0.5, 0.2 * 0.4])
    momentum = 1.6 * run.v[:, 0] + (mu * np.cos(phi) * phi_dot).sum(axis=1)
    assert np.allclose(momentum, 0.7 * run.t, atol=1e-9)
    assert np.array_equal(run.u, np.full((5, 1), 0.7))


def test_control_law_gets_time_and_state_and_its_slope_reaches_the_jacobian() -> None:
    """A law that cancels gravity and damps leaves theta'' = -a theta' - b theta, with a known solution."""
    inertia = 1.3 * LENGTH**2
    system = planar([1.3], [LENGTH], actuated="all")

    def law(t: float, x: np.ndarray) -> np.ndarray:
        return np.array([1.3 * GRAVITY * LENGTH * np.sin(x[0]) - inertia * (1001.0 * x[1] + 1000.0 * x[0])])

    run = simulate(system, [1.0, 0.0], np.linspace(0, 5, 11), "Radau", 1e-8, u=law)
    exact = (1000 * np.exp(-run.t) - np.exp(-1000 * run.t)) / 999
    assert np.max(np.abs(run.q[:, 0] - exact)) < 1e-6
    assert run.counts["steps"] < 500
    assert np.allclose(run.u[:, 0], [law(t, x)[0] for t, x in zip(run.t, run.x, strict=True)])


def test_runtime_parameters_reach_the_dynamics() -> None:
    def dynamics(q: np.ndarray, v: np.ndarray, *, p: dict[str, float]) -> np.ndarray:
        return -p["gravity"] / p["length"] * np.sin(q)

    system = System("p", "planar", "fixed", 1, 1, 1, 0, functions={"forward_dynamics": dynamics},
                    params={"gravity": 1.0, "length": LENGTH})  # fmt: skip
    run = simulate(system, [2.0, 0.0], [0, 1.0], p={"gravity": GRAVITY})
    assert abs(run.q[-1, 0] - exact_angle(1.0, 2.0)) < 1e-8


@pytest.mark.long
@pytest.mark.parametrize("method", ["DOP853", "LSODA", "step", "cvodes"])
def test_events_are_located(method: str) -> None:
    """From rest at 2 rad the pendulum hangs after a quarter period, and is at rest again after half of one."""
    quarter = ellipk(np.sin(1.0) ** 2) / OMEGA_0
    system = pendulum(with_casadi=method == "cvodes")
    events = [Event("hanging", lambda t, x: x[0]), Event("rest", lambda t, x: x[1], direction=1)]
    run = simulate(system, [2.0, 0.0], [0, 4 * quarter + 0.01], method, 1e-11, h=1e-3, events=events)
    found = [(crossing.name, crossing.t) for crossing in run.events]
    assert [name for name, _ in found] == ["hanging", "rest", "hanging"]
    assert np.allclose([t for _, t in found], [quarter, 2 * quarter, 3 * quarter], rtol=0, atol=1e-8)


def test_a_terminal_event_ends_the_run() -> None:
    quarter = ellipk(np.sin(1.0) ** 2) / OMEGA_0

    def hanging(t: float, x: np.ndarray) -> float:
        return x[0]

    hanging.terminal = True
    for t in ([0, 9.0], np.linspace(0, 9, 50)):
        run = simulate(pendulum(), [2.0, 0.0], t, tol=1e-12, events=hanging)
        assert run.status == "event" and "hanging" in run.reason
        assert abs(run.t[-1] - quarter) < 1e-11 and abs(run.q[-1, 0]) < 1e-10


def test_two_crossings_within_one_step_are_both_found() -> None:
    """DOP853 crosses several zeros of a fast scalar in one of its long steps."""
    run = simulate(pendulum(), [0.01, 0.0], [0, 2.0], tol=1e-4, events=lambda t, x: np.cos(20 * t))
    assert np.allclose([c.t for c in run.events], (np.arange(13) + 0.5) * np.pi / 20, atol=1e-12)


def test_backwards_returns_to_the_start() -> None:
    system = uniform_planar(3)
    x0 = np.array([0.8, -0.4, 0.3, 0.1, 0.0, -0.2])
    there = simulate(system, x0, [0, 2.0], tol=1e-12)
    back = simulate(system, there.x[-1], [2.0, 0.0], tol=1e-12)
    assert np.max(np.abs(back.x[-1] - x0)) < 1e-9
    assert np.all(np.diff(back.t) < 0)


@settings(max_examples=15, deadline=None)
@given(
    st.integers(1, 3),
    st.sampled_from(["relative", "absolute", "adjacent"]),
    st.booleans(),
    st.lists(st.floats(-2, 2), min_size=8, max_size=8),
)
def test_energy_is_kept_and_damping_only_takes_it(
    n: int, angles: str, on_cart: bool, numbers: list[float]
) -> None:
    masses, lengths = [0.3, 0.5, 0.4][:n], [0.4, 0.6, 0.3][:n]
    cart_mass = 0.8 if on_cart else None
    nq = n + int(on_cart)
    x0 = np.array(numbers[: 2 * nq])
    free = simulate(planar(masses, lengths, angles=angles, cart_mass=cart_mass), x0, [0, 1.0])
    scale = max(1.0, np.max(np.abs(free.energy)))
    assert free.energy_drift < 1e-7 * scale
    damped = planar(masses, lengths, angles=angles, cart_mass=cart_mass, damping=[0.3] * n)
    assert np.all(np.diff(simulate(damped, x0, [0, 1.0]).energy) < 1e-8 * scale)
