"""What stands in the table of a swing-up: gains against brute force, an observer against the whole Kalman filter, derivatives of the step."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import solve_discrete_are

from phichain import build
from phichain.control import Sensors
from phichain.control.swing_up import Chain, Design, Plan, Task, law_along
from phichain.control.swing_up.gains import catch_gains, linear_path, regulated
from phichain.control.swing_up.sight import observer_along
from tests.trials.test_swing_up import M0, POLE, G, M, pole


def test_gains_that_expect_errors_are_the_best_of_those_that_look_at_the_deviation_alone() -> None:
    """By brute force: the expected cost of the linear closed loop, from the covariance alone, grows whichever way gains are moved."""
    scene = replace(POLE, want=("forward_dynamics", "linearization"), mass="runtime")
    chain = Chain(replace(build(scene), params={"mass": [M]}))
    task = Task.of(chain.system, limit=20, sample=0.02)
    derivatives = chain.derivatives(task.sample)
    count = 12
    x = np.linspace([0, 2.5, 0, 1], [0, np.pi, 0, 0], count + 1)
    u = np.linspace(4, 0, count)[:, None]
    plan = Plan(
        "pole", "", np.arange(count + 1) * task.sample, x, u, ("x", "theta_1", "x_dot", "theta_dot_1"), ("force",), (1,), (-1,),
        np.array([20.0]), 0.0, task.sample, "none", True, 0, 0.0, 0.0, 0.0,
    )  # fmt: skip
    design, errors, spread = Design(0.3, 1e-5), np.array([0.3]), 1e-3
    path, (Q, R, S) = linear_path(derivatives, x, u), catch_gains(chain, task, derivatives, design)
    gains = law_along(chain, task, plan, design, errors, spread, stride=1).gains[:-1]
    plain = law_along(chain, task, plan, design, 0 * errors, spread, stride=1).gains[:-1]
    assert np.array_equal(plain, regulated(path, Q, R, S))
    rate = design.noise / task.swing * np.sqrt(task.sample / 1e-3)
    noise = np.diag([task.sample * rate] * 2 + [rate] * 2 + [0]) ** 2

    def cost(gains: np.ndarray) -> float:
        P = np.diag([0, spread**2 / 3, 0, 0, 0.3**2 / 3]) + noise
        total = 0.0
        for A, B, E, K in zip(*path, gains, strict=True):
            total += np.trace((Q + K.T @ R @ K) @ P[:4, :4])
            closed = np.block([[A - B @ K, E], [np.zeros((1, 4)), np.ones((1, 1))]])
            P = closed @ P @ closed.T + noise
        return float(total + np.trace(S @ P[:4, :4]))

    best, draw = cost(gains), np.random.default_rng(1)
    assert best < 0.9 * cost(plain)
    steps = draw.normal(size=(20, *gains.shape)) * np.mean(np.abs(gains), axis=0)
    slopes = [max(abs(cost(at + 1e-4 * step) - cost(at - 1e-4 * step)) for step in steps) for at in (gains, plain)]
    assert slopes[0] < 0.05 * slopes[1]


def test_an_observer_along_the_motion_finds_the_masses_as_well_as_can_be() -> None:
    """By brute force: the covariance of what is estimated grows whichever way its last correction is moved; ends are stationary filters."""
    scene = replace(POLE, want=("forward_dynamics", "linearization"), mass="runtime")
    chain = Chain(replace(build(scene), params={"mass": [M]}))
    task = Task.of(chain.system, limit=20, sample=0.02)
    derivatives, count = chain.derivatives(task.sample), 12
    x, u = np.linspace([0, 2.5, 0, 1], [0, np.pi, 0, 0], count + 1), np.linspace(4, 0, count)[:, None]
    path = linear_path(derivatives, x, u)
    still = np.array([0, np.pi, 0, 0])
    end = tuple(np.array(part) for part in derivatives(still, [0.0])[:2])
    sensors, errors = Sensors(resolution={"x": 1e-3, "theta_1": 5e-3}, disturbance={"x": 0.5, "theta_1": 2.0}), np.array([0.3])
    S = solve_discrete_are(*end, np.eye(4), np.eye(1))
    hold = np.linalg.solve(1 + end[1].T @ S @ end[1], end[1].T @ S @ end[0])
    exact, made = (observer_along(chain, task, path, (end[0], end[1]), hold, sensors, one, np.arange(count + 1)) for one in (0 * errors, errors))
    V, h = np.diag([1e-3, 5e-3]) ** 2 / 12, task.sample
    N, C = np.diag([0.5, 2.0]) ** 2, np.eye(2, 4)
    W = np.block([[N * h**3 / 3, N * h**2 / 2], [N * h**2 / 2, N * h]])
    P = solve_discrete_are(end[0].T, C.T, W, V)
    assert np.allclose(exact.corrections[-1], P @ C.T @ np.linalg.inv(C @ P @ C.T + V), rtol=1e-6)
    assert np.allclose(made.flows[3], (path[0][3] - np.eye(4))[2:]) and np.allclose(made.drives[-1], end[1][2:])
    first = solve_discrete_are(path[0][0].T, C.T, W, V)
    known = made.learning
    assert exact.learning is None and known is not None and made.estimated == 5 and known.bounds == pytest.approx([0.6])
    both = np.concatenate([made.corrections, known.learned], axis=1)
    assert not np.any(known.learned[[0, -1]]) and np.allclose(known.pushes[3], path[2][3][2:]) and not np.any(known.pushes[-1])
    assert np.allclose(known.steps, [1e-3, 5e-3])

    def spread(corrections: np.ndarray, k: int) -> float:
        """What the estimates of state and mass are off after the k-th measurement."""
        P = np.zeros((5, 5))
        P[:4, :4], P[4, 4] = first, 0.3**2 / 3
        for at in range(k + 1):
            kept = np.eye(5)
            kept[:, :2] -= corrections[at]
            P = kept @ P @ kept.T + corrections[at] @ V @ corrections[at].T
            if at < k:
                flow = np.block([[path[0][at], path[2][at]], [np.zeros((1, 4)), np.ones((1, 1))]])
                P = flow @ P @ flow.T
                P[:4, :4] += W
        return float(np.trace(P))

    draw = np.random.default_rng(2)
    assert spread(both, 11) < spread(both * np.array([1, 1, 1, 1, 0])[:, None], 11)
    for k in (0, 5, 11):
        best = spread(both, k)
        for _ in range(6):
            step = np.zeros_like(both)
            step[k] = 0.05 * draw.normal(size=(5, 2)) * np.max(np.abs(both[k]))
            ahead, back = spread(both + step, k) - best, spread(both - step, k) - best
            # A parabola about its lowest point, which it is not about that of a filter that trusts the masses.
            assert min(ahead, back) > 0 and abs(ahead - back) < 1e-6 * (ahead + back)


def test_the_derivatives_are_those_of_the_step() -> None:
    scene = replace(POLE, want=("forward_dynamics", "linearization"), mass="runtime", cart_mass="runtime")
    chain = Chain(replace(build(scene), params={"cart_mass": M0, "mass": [M]}))
    assert np.array_equal(chain.parameters, [M, M0]) and chain.push == pytest.approx([G * M0], rel=1e-12)
    x, u, h = np.array([0.1, 2.0, 0.3, -4.0]), np.array([3.0]), 1e-6
    step, found = chain.step(1e-3), chain.derivatives(1e-3)(x, u)
    heavier = solve_ivp(lambda t, z: pole(z, 3.0, 1.2 * M, 0.9 * M0), (0, 1e-3), x, rtol=1e-10, atol=1e-13).y[:, -1]
    assert np.allclose(np.array(step(x, u, [0.2, -0.1])).ravel(), heavier, rtol=0, atol=1e-11)
    for given, size in enumerate((4, 1, 2)):
        for k in range(size):
            ends = []
            for side in (h, -h):
                point = [x.copy(), u.copy(), np.zeros(2)]
                point[given][k] += side
                ends.append(np.array(step(*point)).ravel())
            assert np.allclose(np.array(found[given])[:, k], (ends[0] - ends[1]) / (2 * h), atol=1e-8)
