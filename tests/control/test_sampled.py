"""Regulators of sampled chains: against the equations in 60 digits, against the continuous ones, and in closed loop with holds."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from mpmath import mp
from scipy.linalg import expm

from phichain.control import Gains, linearize, lqr, regulators
from phichain.control.equations.sampled import held, sampled_riccatis
from phichain.errors import ArrayError, ControlError
from phichain.system import System
from tests.handmade import paper_b, planar, spatial

CHAINS = {
    "cart": (planar([0.3, 0.2], [0.4, 0.3], cart_mass=0.7, actuated="cart"), (-1, -1)),
    "joints": (planar([0.3, 0.2], [0.4, 0.3], [0.2, 0.2], actuated="all", damping=[0.1, 0.2]), (1, -1)),
    "space": (spatial([0.2, 0.1], [0.3, 0.4], cart_mass=0.5), (-1, 1)),
    "paper B": (paper_b(), (-1, -1, -1, 1, 1)),
}
SAMPLES = (0.03, 1e-3, 1e-5)


def exactly(A: np.ndarray, B: np.ndarray, sample: float) -> tuple[mp.matrix, mp.matrix]:
    """exp of the whole matrix by mpmath; call within workdps."""
    n, nu = B.shape
    whole = mp.zeros(n + nu)
    for i in range(n):
        for j in range(n + nu):
            whole[i, j] = mp.mpf(float(A[i, j] if j < n else B[i, j - n])) * mp.mpf(sample)
    flow = mp.expm(whole)
    return flow[:n, :n], flow[:n, n:]


@pytest.mark.parametrize("sample", SAMPLES)
@pytest.mark.parametrize("name", CHAINS)
def test_the_gains_fulfil_the_equation_in_60_digits(name: str, sample: float) -> None:
    """S of the record is a double: one step of the Riccati iteration from it, in 60 digits, gives the gains to 1e-9 and better."""
    system, s = CHAINS[name]
    gains = lqr(system, s, Q=2.0, R=0.5, sample=sample)
    A, B = linearize(system, s).first_order
    with mp.workdps(60):
        a, b = exactly(A, B, sample)
        S, Q, R = (mp.matrix(matrix.tolist()) for matrix in (gains.S, gains.Q, gains.R))
        for _ in range(3):
            K = mp.inverse(R + b.T * S * b) * (b.T * S * a)
            S = a.T * S * (a - b * K) + Q
        expected = np.array(K.tolist(), dtype=float)
        moved = max(abs(S[i, j] - gains.S[i, j]) for i in range(S.rows) for j in range(S.cols))
    assert float(moved) <= 1e-13 * np.max(np.abs(gains.S))
    assert np.max(np.abs(gains.K - expected)) <= 1e-9 * np.max(np.abs(expected))
    assert gains.residual < 1e-14 and gains.sample == sample


def test_a_mutant_of_the_equation_is_noticed() -> None:
    """The continuous gains, however short the samples, are others by more than the test above lets through."""
    system, s = CHAINS["cart"]
    sampled, continuous = lqr(system, s, sample=1e-5), lqr(system, s)
    off = np.max(np.abs(sampled.K - continuous.K)) / np.max(np.abs(continuous.K))
    assert 1e-6 < off < 1e-3


@pytest.mark.parametrize("name", CHAINS)
def test_short_samples_lead_to_the_continuous_regulator(name: str) -> None:
    """K(T) = K + O(T)."""
    system, s = CHAINS[name]
    continuous = lqr(system, s)
    off = [np.max(np.abs(lqr(system, s, sample=sample).K - continuous.K)) for sample in (2e-6, 1e-6)]
    assert off[0] / off[1] == pytest.approx(2, rel=1e-2)
    assert off[1] < 1e-4 * np.max(np.abs(continuous.K))


@pytest.mark.parametrize("name", CHAINS)
def test_poles_are_those_of_the_sampled_loop(name: str) -> None:
    system, s = CHAINS[name]
    gains = lqr(system, s, sample=0.01)
    n = len(gains.A)
    flow = expm(np.block([[gains.A, gains.B], [np.zeros((gains.B.shape[1], n + gains.B.shape[1]))]]) * 0.01)
    closed = flow[:n, :n] - flow[:n, n:] @ gains.K
    assert sorted(np.abs(np.exp(gains.poles * 0.01))) == pytest.approx(sorted(np.abs(np.linalg.eigvals(closed))), abs=1e-6)
    assert gains.decay > 0


def test_the_exponential_is_exact_over_long_and_short_holds() -> None:
    system, s = CHAINS["cart"]
    A, B = linearize(system, s).first_order
    for sample in (3.0, 0.3, 1e-3, 1e-9):
        found = held(A, B, sample)
        with mp.workdps(60):
            for matrix, wide in zip(exactly(A, B, sample), found, strict=True):
                size = max(abs(entry) for entry in matrix)
                for i in range(matrix.rows):
                    for j in range(matrix.cols):
                        value = mp.mpf(float(wide.high[i, j])) + mp.mpf(float(wide.low[i, j]))
                        assert abs(value - matrix[i, j]) < mp.mpf(10) ** -27 * size


def test_the_law_keeps_the_chain_upright_with_its_input_held() -> None:
    """Flow from sample to sample with the input held: what it is designed for; the continuous gains at that period let it fall."""
    system, s = CHAINS["cart"]
    sample = 0.07

    def ends(gains: Gains) -> float:
        n = len(gains.A)
        flow = expm(np.block([[gains.A, gains.B], [np.zeros((1, n + 1))]]) * sample)
        z = np.full(n, 1e-3)
        for _ in range(400):
            z = flow[:n, :n] @ z - flow[:n, n] * (gains.K @ z)
        return float(np.max(np.abs(z)))

    assert ends(lqr(system, s, sample=sample)) < 1e-6
    assert ends(lqr(system, s)) > 1


def test_all_equilibria_at_once_are_those_one_by_one() -> None:
    system, _ = CHAINS["space"]
    for gains in regulators(system, sample=0.01):
        alone = lqr(system, gains.s, sample=0.01)
        assert np.array_equal(gains.K, alone.K) and gains.sample == 0.01


def test_the_record_and_its_law_keep_the_period(tmp_path) -> None:
    system, s = CHAINS["cart"]
    gains = lqr(system, s, sample=0.01)
    assert "sampled every 0.01 s" in str(gains)
    assert Gains.from_npz(gains.to_npz(tmp_path / "gains.npz")).sample == 0.01
    law = gains.law(limit=5)
    assert law.sample == 0.01
    assert type(law).from_npz(law.to_npz(tmp_path / "law.npz")) == law
    with pytest.raises(ArrayError, match="is no time between two calls"):
        replace(law, sample=-1.0)


@pytest.mark.parametrize("sample", [0.0, -1e-3, np.nan, np.inf, "fast", True])
def test_what_is_no_period_is_refused(sample: object) -> None:
    system, s = CHAINS["cart"]
    with pytest.raises(ControlError, match="is no positive time"):
        lqr(system, s, sample=sample)  # type: ignore[arg-type]


def test_a_period_too_long_for_the_fastest_mode_is_refused() -> None:
    system, s = CHAINS["cart"]
    with pytest.raises(ControlError, match="is too long: between two samples the mode lambda = .* grows by .* sample at least every"):
        lqr(system, s, sample=1.0)


def test_an_oscillation_that_every_sample_meets_alike_is_refused() -> None:
    """x'' = -(2 pi)^2 x sampled every second: held inputs never move it."""
    A, B = np.array([[0.0, 1.0], [-((2 * np.pi) ** 2), 0.0]]), np.array([[0.0], [1.0]])
    with pytest.raises(ControlError, match="leaves no stabilising solution"):
        sampled_riccatis(A[None], B[None], np.eye(2), np.eye(1), 1.0)


def test_systems_by_hand_have_a_sample_too() -> None:
    system: System = CHAINS["joints"][0]
    assert lqr(system, (1, 1), sample=0.01).K.shape == (2, 4)
