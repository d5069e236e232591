"""Gains against 40 digits, against other solvers, and on the nonlinear chain."""

from __future__ import annotations

import dataclasses
from itertools import product

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import simpson

from phichain.control import Gains, deviation, errors, feedback, lqr
from phichain.control.equations.riccati import ordered_schur
from phichain.errors import ArrayError, OutputError
from phichain.motion import simulate
from tests import tables
from tests.handmade import paper_b, planar, spatial

PAPER_B = paper_b()
ALONG_1 = [0, 3, 5, 7, 9, 11, 12, 15, 17, 19, 21, 23]
"""Motion along e_1 within z: cart position, rotations about e_2, and their rates."""


def exact_gains(A: np.ndarray, B: np.ndarray, Q: np.ndarray, R: np.ndarray) -> np.ndarray:
    """K by the matrix sign function of the Hamiltonian in 40 digits (Roberts 1971)."""
    with mpmath.workdps(40):
        n = len(A)
        a, b, q, r = (mpmath.matrix(part.tolist()) for part in (A, B, Q, R))
        gain = r**-1 * b.T
        z = mpmath.zeros(2 * n)
        z[:n, :n], z[:n, n:], z[n:, :n], z[n:, n:] = a, -b * gain, -q, -a.T
        for step in range(40):
            factor = abs(mpmath.det(z)) ** (mpmath.mpf(-1) / (2 * n)) if step < 8 else 1
            new = (factor * z + z**-1 / factor) / 2
            moved, z = mpmath.mnorm(new - z, 1) / mpmath.mnorm(new, 1), new
            if moved < 1e-30:
                break
        z += mpmath.eye(2 * n)
        left, right = z[:, n:], -z[:, :n]
        S = (left.T * left) ** -1 * (left.T * right)
        return np.array((gain * S).tolist(), dtype=float)


@pytest.mark.parametrize("s", [(-1, -1, -1, -1, -1), (1, -1, -1, 1, 1)])
def test_gains_are_right_to_the_last_digits(s) -> None:
    """The planes do not mix, so the gains along e_1 are those of a 12-state problem that 40 digits can solve."""
    gains = lqr(PAPER_B, s)
    A, Q = (part[np.ix_(ALONG_1, ALONG_1)] for part in (gains.A, gains.Q))
    exact = exact_gains(A, gains.B[ALONG_1][:, :1], Q, gains.R[:1, :1])
    assert np.max(np.abs(gains.K[0, ALONG_1] - exact[0])) < 5e-14 * np.max(np.abs(exact))


def test_all_32_equilibria_agree_with_other_solvers() -> None:
    """python-control to 1e-8; the ordered Schur form, which loses more, to 1e-7 (it is 1e-8 off itself)."""
    control = pytest.importorskip("control")
    for s in product((1, -1), repeat=5):
        gains = lqr(PAPER_B, s)
        peer = control.lqr(gains.A, gains.B, gains.Q, gains.R)[0]
        schur = np.linalg.solve(gains.R, gains.B.T @ ordered_schur(gains.A, gains.B, gains.Q, gains.R))
        size = np.max(np.abs(gains.K))
        assert np.max(np.abs(gains.K - peer)) < 1e-8 * size
        assert np.max(np.abs(gains.K - schur)) < 1e-7 * size
        assert gains.decay > 0 and gains.residual < 1e-15
        assert np.all(np.linalg.eigvalsh(gains.S) > 0)


def test_weights_may_be_numbers_diagonals_or_matrices() -> None:
    by_number = lqr(PAPER_B, Q=2.0, R=0.5)
    by_diagonal = lqr(PAPER_B, Q=np.full(24, 2.0), R=[0.5, 0.5])
    by_matrix = lqr(PAPER_B, Q=2 * np.eye(24), R=np.eye(2) / 2)
    assert by_number.s == (-1,) * 5
    assert np.array_equal(by_number.K, by_diagonal.K) and np.array_equal(by_number.K, by_matrix.K)
    scaled = lqr(PAPER_B, Q=8.0, R=2.0)
    assert np.allclose(scaled.K, by_number.K, rtol=1e-11) and np.allclose(
        scaled.S, 4 * by_number.S, rtol=1e-11
    )


def test_a_weight_that_is_no_multiple_of_the_identity() -> None:
    """Coupled inputs: the refinement must use R's inverse to more than double precision."""
    R = np.array([[1.0, 0.9], [0.9, 1.3]])
    gains = lqr(spatial([0.3], [0.4], cart_mass=0.6), (-1,), Q=np.diag(np.arange(1.0, 9.0)), R=R)
    exact = exact_gains(gains.A, gains.B, gains.Q, R)
    assert np.max(np.abs(gains.K - exact)) < 1e-14 * np.max(np.abs(exact))


def test_a_plane_of_the_spatial_chain_is_the_planar_chain() -> None:
    """Rotation xi_2 about e_2 swings towards +e_1 like a positive planar angle."""
    flat = planar([0.1] * 5, [0.1] * 5, cart_mass=0.5, angles="absolute", actuated="cart")
    for s in ((-1,) * 5, (1, -1, 1, 1, -1)):
        spatial_gains, planar_gains = lqr(PAPER_B, s), lqr(flat, s)
        assert np.allclose(spatial_gains.K[0, ALONG_1], planar_gains.K[0], rtol=1e-9)
        assert spatial_gains.decay == pytest.approx(planar_gains.decay, rel=1e-9)


def nudged(s, angles, azimuth: float = 0.7) -> np.ndarray:
    """At rest, every link turned by its angle from s_k e_3."""
    tilt = np.asarray(angles, float)
    level = np.sin(tilt)[:, None] * [np.cos(azimuth), np.sin(azimuth)]
    directions = np.column_stack([level, np.array(s) * np.cos(tilt)])
    return np.concatenate([[0.0, 0.0], directions.ravel(), np.zeros(17)])


@pytest.mark.long
@pytest.mark.parametrize(
    ("s", "tilt"), [((1, 1, 1, 1, 1), 0.3), ((1, -1, -1, 1, 1), 5e-3), ((-1,) * 5, 4e-4)]
)
def test_the_nonlinear_chain_is_caught(s, tilt: float) -> None:
    """From a small start the closed loop settles at the target, at the rate of its slowest eigenvalue or faster."""
    gains = lqr(PAPER_B, s)
    run = simulate(PAPER_B, nudged(s, [tilt] * 5), [0, 8.0], tol=1e-6, u=feedback(PAPER_B, gains))
    e_q, e_omega = errors(PAPER_B, gains, run.x)
    assert e_q[0] == pytest.approx(10 * np.sin(tilt / 2))
    assert e_q[-1] < 20 * e_q[0] * np.exp(-gains.decay * 8) and e_omega[-1] < 1e-2 * np.max(e_omega)


def test_the_cost_to_go_is_the_cost_that_comes() -> None:
    """z_0^T S z_0 = int (z^T Q z + u^T R u) dt along the nonlinear motion, for a start so small that it is linear."""
    system = planar([0.2, 0.1], [0.5, 0.4], cart_mass=0.6, actuated="cart", stiffness=[0.0, 0.0])
    gains = lqr(system, (1, -1), Q=[1, 2, 3, 4, 5, 6], R=0.7)
    law, z_of = feedback(system, gains, target=[0.3]), deviation(system, gains, target=[0.3])
    start = np.concatenate([gains.equilibrium + [0.3 + 2e-5, 1e-5, -1e-5], np.zeros(3)])
    run = simulate(system, start, np.linspace(0, 12, 2401), "DOP853", 1e-7, atol=1e-12, u=law)
    z = z_of(run.x)
    rate = np.einsum("ti,ij,tj->t", z, gains.Q, z) + 0.7 * run.u[:, 0] ** 2
    cost = simpson(rate, x=run.t)
    assert cost == pytest.approx(z[0] @ gains.S @ z[0], rel=1e-4)
    assert run.q[-1, 0] == pytest.approx(0.3, abs=1e-6)


def test_the_law_is_equation_22_by_blocks() -> None:
    s = (1, -1, -1, 1, 1)
    gains, rng = lqr(PAPER_B, s), np.random.default_rng(3)
    x = nudged(s, rng.uniform(-0.2, 0.2, 5))
    x[:2], x[17:] = rng.normal(size=2), 0.3 * rng.normal(size=17)
    K = gains.blocks
    assert {name: block.shape for name, block in K.items()} == {
        "K_x": (2, 2), "K_q": (2, 10), "K_xdot": (2, 2), "K_omega": (2, 10)
    }  # fmt: skip
    expected = -K["K_x"] @ (x[:2] - [1.0, 2.0]) - K["K_xdot"] @ x[17:19]
    for i in range(5):
        q, omega = x[2 + 3 * i : 5 + 3 * i], x[19 + 3 * i : 22 + 3 * i]
        xi = np.cross([0, 0, s[i]], q)
        expected -= K["K_q"][:, 2 * i : 2 * i + 2] @ xi[:2] + K["K_omega"][:, 2 * i : 2 * i + 2] @ omega[:2]
    law = feedback(PAPER_B, gains, target=[1.0, 2.0])
    assert np.allclose(law(0.0, x), expected, rtol=1e-12)
    batch = deviation(PAPER_B, gains)(np.array([x, x]))
    assert batch.shape == (2, 24) and np.array_equal(batch[0], batch[1])


def test_the_law_turns_with_the_chain() -> None:
    """With isotropic weights, turning the state about the vertical turns the force."""
    s, angle = (-1, 1, -1, 1, -1), 0.9
    law, rng = feedback(PAPER_B, lqr(PAPER_B, s)), np.random.default_rng(4)
    x = nudged(s, rng.uniform(-0.2, 0.2, 5))
    x[:2], x[17:] = rng.normal(size=2), rng.normal(size=17)
    c, w = np.cos(angle), np.sin(angle)
    turn2 = np.array([[c, -w], [w, c]])
    turn3 = np.block([[turn2, np.zeros((2, 1))], [np.zeros((1, 2)), np.eye(1)]])
    whole = np.zeros((34, 34))
    for start, size in [
        (0, 2),
        (17, 2),
        *((2 + 3 * k, 3) for k in range(5)),
        *((19 + 3 * k, 3) for k in range(5)),
    ]:
        whole[start : start + size, start : start + size] = turn2 if size == 2 else turn3
    assert np.allclose(
        law(0.0, whole @ x), turn2 @ law(0.0, x), rtol=0, atol=1e-8 * np.max(np.abs(law(0.0, x)))
    )


@pytest.mark.parametrize("angles", ["relative", "absolute", "adjacent"])
def test_planar_angles_count_modulo_a_turn(angles: str) -> None:
    system = planar([0.2, 0.1, 0.3], [0.5, 0.4, 0.3], cart_mass=0.6, angles=angles, actuated="cart")
    gains = lqr(system, (1, -1, 1))
    law = feedback(system, gains)
    x = np.concatenate([gains.equilibrium, np.zeros(4)])
    assert np.max(np.abs(system.forward_dynamics(x[:4], x[4:], law(0.0, x)))) < 1e-11
    x = x + 0.01
    around = x + np.array([0, 2, -4, 6, 0, 0, 0, 0]) * np.pi
    assert np.allclose(law(0.0, x), law(0.0, around), rtol=1e-9)
    e_q, e_omega = errors(system, gains, np.concatenate([gains.equilibrium, np.zeros(4)]))
    assert e_q < 1e-14 and e_omega == 0


@settings(max_examples=25)
@given(
    st.lists(st.tuples(st.floats(0.05, 2), st.floats(0.1, 1.5), st.floats(0.3, 1)), min_size=1, max_size=3),
    st.floats(0.1, 5),
    st.sampled_from(["relative", "absolute", "adjacent"]),
    st.lists(st.sampled_from([1, -1]), min_size=3, max_size=3),
    st.booleans(),
)
def test_any_controllable_chain_is_stabilised(links, cart_mass, angles, signs, damped) -> None:
    mass, length, share = map(np.array, zip(*links, strict=True))
    system = planar(
        mass, length, share * length, cart_mass=cart_mass, angles=angles, actuated="cart",
        damping=[0.1] * len(mass) if damped else None,
    )  # fmt: skip
    s = signs[: len(mass)]
    from phichain.control import controllability

    if controllability(system, s).margin < 1e-4:
        return
    gains = lqr(system, s)
    assert gains.decay > 0 and gains.residual < 1e-14
    assert np.max(np.abs(gains.K - np.linalg.solve(gains.R, gains.B.T @ gains.S))) < 1e-6 * np.max(
        np.abs(gains.K)
    )


def test_files_round_trip(tmp_path) -> None:
    gains = lqr(PAPER_B, (1, -1, 1, 1, 1))
    copy = Gains.from_npz(gains.to_npz(tmp_path / "gains.npz"))
    for item in dataclasses.fields(Gains):
        assert np.array_equal(getattr(copy, item.name), getattr(gains, item.name)), item.name
    lines = tables.lines(gains.to_csv(tmp_path / "gains.csv"))
    assert lines[0] == "state,K_force_1,K_force_2" and len(lines) == 25
    assert lines[3].startswith("xi_1_1,") and float(lines[4].split(",")[1]) == gains.K[0, 3]
    with pytest.raises(dataclasses.FrozenInstanceError):
        gains.name = "other"  # type: ignore[misc]
    with pytest.raises(OutputError, match="no Gains"):
        Gains.from_npz(tmp_path / "gains.csv")
    assert "slowest closed-loop eigenvalue -0.8" in str(gains)


def test_gains_of_another_chain_are_refused() -> None:
    gains = lqr(PAPER_B)
    other = planar([0.1], [0.1], cart_mass=0.5, actuated="cart")
    with pytest.raises(ArrayError, match="spatial chain of 5"):
        feedback(other, gains)
    with pytest.raises(ArrayError, match="2 finite position"):
        feedback(PAPER_B, gains, target=[1.0])
