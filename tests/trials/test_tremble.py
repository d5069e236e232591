"""Corrections of a chain that is held through encoders: what is left of wrong masses does to its tremble, and the best against it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import solve_discrete_are

from phichain import Scene, build
from phichain.control.swing_up import Chain
from phichain.control.swing_up.tremble import EDGE, LASTING, SAID_AGAIN, STILL, bends, held_corrections

SAMPLE = 0.005
SCENE = Scene("trembling", 2, base="cart", cart_mass=0.5, mass="runtime", length=0.2, want=("forward_dynamics", "linearization"))
REST = np.array([0, np.pi, 0, 0, 0, 0])
STEPS = np.array([1e-4, 1.5e-3, 1.5e-3])
V = np.diag(STEPS) ** 2 / 12


def chain(masses: list[float]) -> Chain:
    return Chain(replace(build(SCENE), params={"mass": masses}))


@pytest.fixture(scope="module")
def held() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(A, B, K) of the upright chain and some regulator."""
    A, B = (np.array(part) for part in chain([0.1, 0.1]).derivatives(SAMPLE)(REST, [0.0])[:2])
    S = solve_discrete_are(A, B, np.eye(6), np.eye(1))
    return A, B, np.linalg.solve(1 + B.T @ S @ B, B.T @ S @ A)


def test_bends_are_the_differences_of_chains_with_other_masses() -> None:
    A_k, B_k = bends(chain([0.1, 0.1]), REST, SAMPLE)
    assert A_k.shape == (2, 6, 6) and B_k.shape == (2, 6, 1)
    for k in range(2):
        pair = []
        for error in (1e-4, -1e-4):
            masses = [0.1, 0.1]
            masses[k] *= 1 + error
            pair.append([np.array(part) for part in chain(masses).derivatives(SAMPLE)(REST, [0.0])[:2]])
        for found, plus, minus in zip((A_k[k], B_k[k]), *pair, strict=True):
            assert np.allclose(found, (plus - minus) / 2e-4, atol=1e-7 * max(1.0, np.max(np.abs(found))))


def trembling(A: np.ndarray, B: np.ndarray, K: np.ndarray, L: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Covariances of state and input of the loop that rounding keeps going, by letting it run."""
    C, both = np.eye(3, 6), np.zeros((12, 12))
    kept = np.eye(6) - L @ C
    after = np.block([[A - B @ K @ L @ C, -B @ K @ kept], [(A - B @ K) @ L @ C, (A - B @ K) @ kept]])
    noisy = np.vstack([-B @ K @ L, (A - B @ K) @ L])
    for _ in range(6000):
        both = after @ both @ after.T + noisy @ V @ noisy.T
    pushed = K @ np.hstack([L @ C, kept])
    return both[:6, :6], pushed @ both @ pushed.T + K @ L @ V @ L.T @ K.T


def test_corrections_are_the_best_for_the_noise_that_they_leave(held: tuple[np.ndarray, np.ndarray, np.ndarray]) -> None:
    """The loop's covariance by letting it run, the noise from that, and no other correction is better for it."""
    A, B, K = held
    bent, left = bends(chain([0.1, 0.1]), REST, SAMPLE), np.array([[0.01, -0.003], [-0.003, 0.04]]) / 3
    W, C = 1e-3 * np.eye(6), np.eye(3, 6)
    inside, outside = held_corrections((A, B), K, bent, left, (V, W), SAMPLE, STEPS)
    # The noise is linear in what is left: its turns are taken here from the outside, to where they come to rest.
    L = np.zeros((6, 3))
    noise = W
    for _ in range(9):
        P = solve_discrete_are(A.T, C.T, noise, V)
        L = P @ C.T @ np.linalg.inv(C @ P @ C.T + V)
        X, U = trembling(A, B, K, L)
        noise = STILL**2 * W
        for k in range(2):
            for j in range(2):
                noise = noise + left[k, j] * LASTING / SAMPLE * (bent[0][k] @ X @ bent[0][j].T + bent[1][k] @ U @ bent[1][j].T)
        noise = (noise + noise.T) / 2
    share = np.minimum(1, SAID_AGAIN * np.sqrt(2 / np.pi) * np.sqrt(np.diag(X)[3:]) * SAMPLE / STEPS)
    assert np.any(share < 1) and np.allclose(inside, L * share, atol=0.01 * np.max(np.abs(inside)))
    for i in range(3):
        assert np.allclose(outside[:, i], P[:, i] / (P[i, i] + EDGE * V[i, i]), atol=0.01 * np.max(np.abs(outside)))

    def spread(L: np.ndarray) -> float:
        P = solve_discrete_are(A.T, C.T, noise, V)
        for _ in range(3000):
            P = A @ ((np.eye(6) - L @ C) @ P @ (np.eye(6) - L @ C).T + L @ V @ L.T) @ A.T + noise
        return float(np.trace(P))

    P = solve_discrete_are(A.T, C.T, noise, V)
    best = P @ C.T @ np.linalg.inv(C @ P @ C.T + V)
    assert np.allclose(L, best, atol=0.01 * np.max(np.abs(best)))
    least, draw = spread(best), np.random.default_rng(3)
    assert all(spread(best * (1 + 0.05 * draw.normal(size=best.shape))) > least for _ in range(3))


def test_an_outer_link_is_believed_to_stay_where_it_is(held: tuple[np.ndarray, np.ndarray, np.ndarray]) -> None:
    """A count of the last encoder moves its rate by far less than white noise on every acceleration makes it, and more beyond than within."""
    A, B, K = held
    C, h = np.eye(3, 6), SAMPLE
    W = np.block([[np.eye(3) * h**3 / 3, np.eye(3) * h**2 / 2], [np.eye(3) * h**2 / 2, np.eye(3) * h]])
    P = solve_discrete_are(A.T, C.T, W, V)
    white = P @ C.T @ np.linalg.inv(C @ P @ C.T + V)
    inside, outside = held_corrections((A, B), K, bends(chain([0.1, 0.1]), REST, SAMPLE), 0.02**2 * np.eye(2), (V, W), SAMPLE, STEPS)
    assert abs(inside[5, 2]) < 0.5 * abs(white[5, 2]) and abs(inside[5, 2]) < abs(outside[5, 2])
