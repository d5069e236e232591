"""Observers against Riccati equations in 60 digits and each other, and sensors that make none."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from mpmath import mp
from scipy.linalg import expm, solve_discrete_are

from phichain.control import Sensors, estimator, lqr
from phichain.control.equations.kalman import gathered
from phichain.errors import ControlError
from tests.control.output.made_laws import CHAINS, PERIOD, gains_of


@pytest.mark.parametrize("chain", CHAINS)
def test_the_kalman_filter_fulfils_its_equation_in_60_digits(chain: str) -> None:
    """The recursion of the covariance in mpmath, from what SciPy's solver leaves, ends at the record's correction."""
    gains = gains_of(chain)
    estimate = estimator(gains, Sensors(noise=0.01))
    n, m = len(gains.A), len(gains.A) // 2
    variances = [(1e-4 if name.startswith("x") else 2 * np.pi / 4096) ** 2 / 12 + 0.01**2 for name in estimate.measured]
    a, _ = held_exactly(gains.A, gains.B)
    rough = solve_discrete_are(np.array(a.tolist(), float).T, estimate.seen.T, added(gains.A, m), np.diag(variances))
    with mp.workdps(60):
        C, V, W, P = (mp.matrix(part.tolist()) for part in (estimate.seen, np.diag(variances), added(gains.A, m), rough))
        for _ in range(60):
            L = P * C.T * mp.inverse(C * P * C.T + V)
            P = a * (P - L * C * P) * a.T + W
        expected = np.array(L.tolist(), dtype=float)
    assert np.max(np.abs(estimate.L - expected)) < 1e-11 * np.max(np.abs(expected))
    kept = (np.eye(n) - estimate.L @ estimate.seen) @ estimate.advance
    assert np.allclose(np.sort(np.abs(np.linalg.eigvals(kept))), np.sort(np.exp(estimate.poles.real * PERIOD)), rtol=1e-9)


def held_exactly(A: np.ndarray, B: np.ndarray) -> tuple[mp.matrix, mp.matrix]:
    n, nu = B.shape
    with mp.workdps(60):
        whole = mp.zeros(n + nu)
        for i in range(n):
            for j in range(n + nu):
                whole[i, j] = mp.mpf(float(A[i, j] if j < n else B[i, j - n])) * mp.mpf(PERIOD)
        flow = mp.expm(whole)
        return flow[:n, :n], flow[:n, n:]


def added(A: np.ndarray, m: int) -> np.ndarray:
    """The integral of e^(A t) N e^(A^T t) by Gauss's rule, N the identity on the accelerations."""
    nodes, weights = np.polynomial.legendre.leggauss(12)
    N = np.diag([0.0] * m + [1.0] * m)
    flows = [expm(A * (1 + node) * PERIOD / 2) for node in nodes]
    return sum(weight * PERIOD / 2 * flow @ N @ flow.T for weight, flow in zip(weights, flows, strict=True))


@pytest.mark.parametrize("chain", CHAINS)
def test_what_noise_adds_is_its_integral(chain: str) -> None:
    A = lqr(CHAINS[chain], sample=PERIOD).A
    m = len(A) // 2
    found = gathered(A, np.diag([0.0] * m + [1.0] * m), PERIOD).high
    assert np.allclose(found, added(A, m), rtol=1e-12, atol=1e-16 * np.max(found))


@pytest.mark.parametrize("chain", CHAINS)
def test_the_reduced_observer_is_the_kalman_filter_of_exact_sensors(chain: str) -> None:
    gains = gains_of(chain)
    exact = estimator(gains, Sensors(resolution=0.0), "reduced")
    near = estimator(gains, Sensors(resolution=1e-9, disturbance=1.0), "kalman")
    assert np.allclose(exact.L, near.L, rtol=1e-5, atol=1e-5 * np.max(np.abs(near.L)))
    assert np.allclose(exact.seen @ exact.L, np.eye(len(exact.seen)), atol=1e-15)
    assert len(exact.poles) == len(gains.A) - len(exact.seen) and exact.spread.min() == 0
    # Its errors are those of the matrices that the law holds, which are zero beside its poles.
    errors = (np.eye(len(gains.A)) - exact.L @ exact.seen) @ exact.advance
    moving = np.sort(np.abs(np.linalg.eigvals(errors)))[len(exact.seen) :]
    assert np.allclose(moving, np.sort(np.exp(exact.poles.real * PERIOD)), rtol=1e-6)
    noisy = estimator(gains, Sensors(resolution=0.01), "reduced")
    assert noisy.poles[0].real > exact.poles[0].real


def test_a_part_of_the_positions_is_enough_where_it_shows_every_mode() -> None:
    gains = gains_of("plane")
    estimate = estimator(gains, Sensors(measured=("x", "theta_2")))
    errors = (np.eye(6) - estimate.L @ estimate.seen) @ estimate.advance
    assert np.max(np.abs(np.linalg.eigvals(errors))) < 1
    with pytest.raises(ControlError, match=r"measured: do not show the mode lambda = 0.*measure x too") as refused:
        estimator(gains, Sensors(measured=("theta_1", "theta_2")))
    assert refused.value.measured == ("theta_1", "theta_2", "x") and refused.value.margin < 1e-12


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"measured": ("theta",)}, "measured: is nothing of this chain's state"),
        ({"measured": ()}, "measured: names nothing"),
        ({"measured": ("x", "x")}, "measured: names nothing, or something twice"),
        ({"resolution": -1.0}, "resolution: is negative"),
        ({"resolution": {"x": np.nan}}, "resolution: is not a finite number"),
        ({"resolution": {"theta_9": 0.1}}, "resolution: is nothing that it could be of"),
        ({"resolution": 0.0}, "leave a measurement without error"),
        ({"disturbance": 0.0}, "disturbance: leaves no stationary observer"),
    ],
)
def test_sensors_that_make_no_observer_are_refused(arguments: dict[str, Any], words: str) -> None:
    with pytest.raises(ControlError, match=words):
        estimator(gains_of("plane"), Sensors(**arguments))
