"""Powers of inertia matrices along many states against 60 digits, LAPACK and the dense formulas."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.linalg import fractional_matrix_power, lapack

from phichain.errors import ArrayError, ConvergenceError, SignalError, UnsupportedError
from phichain.fractional import factor_spectrum, inertia_factor, inertia_powers, inertia_spectrum
from phichain.fractional.factor import joint_map
from phichain.system import System
from tests.fractional.chains import chain, exact_powers
from tests.handmade import angle_map

POWERS = [0.01, 0.25, 0.5, 0.77, 1.0]
LENGTHS, COMS = [1.0, 0.7, 1.3, 0.5], [1.0, 0.3, 1.3, 0.25]
CHAINS = {
    "uniform": chain([0.25] * 4, [0.25] * 4, [0.125] * 4),
    "heavy tip": chain([1, 1, 1, 1e8], LENGTHS, COMS),
    "heavy root": chain([1e8, 1, 1, 1], LENGTHS, COMS),
    "heavy middle, absolute": chain([1, 1e8, 1, 1], LENGTHS, COMS, angles="absolute"),
    "light middle, adjacent": chain([1, 1e-8, 1, 1], LENGTHS, COMS, angles="adjacent"),
    "heavy tip on a cart": chain([1, 1, 1, 1e8], LENGTHS, COMS, cart_mass=0.5),
    "lengths over eight decades": chain([1] * 4, [1, 1e-4, 1e4, 1], [1, 1e-4, 1e4, 1]),
    "masses near the joints": chain([1] * 4, [1] * 4, [1e-4] * 4),
    "one link": chain([2.0], [3.0]),
}


@pytest.mark.parametrize("name", CHAINS)
def test_powers_agree_with_sixty_digits_at_any_mass_ratio(name: str) -> None:
    system, rng = CHAINS[name], np.random.default_rng(20160101)
    q, u = rng.uniform(-3, 3, (6, system.nq)), rng.standard_normal((6, system.nv))
    found = inertia_powers(inertia_spectrum(system, q), u, POWERS)
    for state in range(len(q)):
        expected = exact_powers(system, q[state], u[state], POWERS)
        for k in range(len(POWERS)):
            scale = max(abs(x) for x in expected[k])
            assert (
                max(abs(mpmath.mpf(found[state, k, i]) - expected[k, i]) for i in range(system.nv))
                < 1e-13 * scale
            )


def test_plain_eigendecomposition_would_lose_the_light_links() -> None:
    system, q = CHAINS["heavy tip"], np.array([0.3, -1.1, 0.4, 0.9])
    F = inertia_factor(system, q)[0]
    u = np.array([1.0, -2.0, 0.5, 1.0])
    values, vectors = np.linalg.eigh(F.T @ F)
    expected = np.array(exact_powers(system, q, u, [1.0])[0], dtype=float)
    plain = vectors @ ((vectors.T @ u) / values)
    assert np.max(np.abs(plain - expected)) > 1e-9 * np.max(np.abs(expected))
    ours = inertia_powers(inertia_spectrum(system, q), u[None], 1.0)[0, 0]
    assert np.max(np.abs(ours - expected)) < 1e-13 * np.max(np.abs(expected))


def test_forces_of_a_heavy_link_need_the_acceleration_to_keep_the_light_ones() -> None:
    system, q = CHAINS["heavy tip"], np.array([[0.3, -1.1, 0.4, 0.9]])
    acceleration = np.array([[1.0, -2.0, 0.5, 3.0]])
    with mpmath.workdps(60):
        exact = exact_powers(system, q[0], acceleration[0], [-1.0, -0.7, -0.5])  # I^(1-p) a
    u = np.array([[float(x) for x in exact[0]]])
    spectrum = inertia_spectrum(system, q)
    found = inertia_powers(spectrum, u, [0.0, 0.3, 0.5, 1.0], acceleration=acceleration)[0]
    assert np.array_equal(found[0], u[0]) and np.array_equal(found[3], acceleration[0])
    for row, expected in zip(found[1:3], exact[1:].astype(float), strict=True):
        assert np.max(np.abs(row - expected)) < 1e-14 * np.max(np.abs(expected))
    # From u alone the weak modes are round-off of the strong one.
    alone = inertia_powers(spectrum, u, 1.0)[0, 0]
    assert np.max(np.abs(alone - acceleration[0])) > 1e-12


@pytest.mark.parametrize("name", CHAINS)
def test_singular_values_agree_with_gejsv(name: str) -> None:
    system = CHAINS[name]
    q = np.random.default_rng(7).uniform(-2, 2, (5, system.nq))
    # LAPACK sees the explicit factor, whose sums bury short links under long ones in relative angles.
    tolerance = 1e-7 if "decades" in name else 1e-13
    for F, sigma in zip(inertia_factor(system, q), inertia_spectrum(system, q).sigma, strict=True):
        values, _, _, work, _, info = lapack.dgejsv(F, joba=2)
        assert info == 0
        expected = np.sort(values * work[0] / work[1])
        assert np.max(np.abs(np.sort(sigma) / expected - 1.0)) < tolerance


@given(st.sampled_from(sorted(CHAINS)), st.integers(0, 2**32 - 1))
def test_factor_squares_to_the_mass_matrix_and_vectors_are_orthonormal(name: str, seed: int) -> None:
    system = CHAINS[name]
    q = np.random.default_rng(seed).uniform(-50, 50, (3, system.nq))
    spectrum = inertia_spectrum(system, q)
    inertia = np.asarray(system.mass_matrix(q))
    F = inertia_factor(system, q)
    assert np.allclose(np.swapaxes(F, 1, 2) @ F, inertia, rtol=0, atol=1e-13 * np.abs(inertia).max())
    rebuilt = (spectrum.vectors * spectrum.sigma[:, None, :] ** 2) @ np.swapaxes(spectrum.vectors, 1, 2)
    assert np.allclose(rebuilt, inertia, rtol=0, atol=1e-13 * np.abs(inertia).max())
    gram = np.swapaxes(spectrum.vectors, 1, 2) @ spectrum.vectors
    assert np.allclose(gram, np.eye(system.nv), rtol=0, atol=1e-13)


@given(
    arrays(float, (3, 5, 3), elements=st.floats(-1.0, 1.0)), arrays(float, 5, elements=st.floats(-8.0, 8.0))
)
def test_any_graded_factor_is_decomposed(noise: np.ndarray, decades: np.ndarray) -> None:
    factor = (noise + 3.0 * np.eye(5, 3)) * 10.0 ** decades[:, None]
    spectrum = factor_spectrum(factor)
    for F, sigma in zip(factor, spectrum.sigma, strict=True):
        with mpmath.workdps(50):
            exact = mpmath.svd_r(mpmath.matrix(F.tolist()), compute_uv=False)
            worst = max(abs(mpmath.mpf(a) / b - 1) for a, b in zip(sorted(sigma), sorted(exact), strict=True))
        assert worst < 1e-12


def test_semigroup_and_scipy_on_an_ordinary_chain() -> None:
    system = CHAINS["uniform"]
    q = np.random.default_rng(1).uniform(-1, 1, (2, 4))
    u = np.random.default_rng(2).standard_normal((2, 4))
    spectrum = inertia_spectrum(system, q)
    half = inertia_powers(spectrum, u, 0.5)[:, 0]
    assert np.allclose(
        inertia_powers(spectrum, half, 0.5)[:, 0], inertia_powers(spectrum, u, 1.0)[:, 0], rtol=1e-12
    )
    for k in range(2):
        expected = fractional_matrix_power(np.asarray(system.mass_matrix(q[k])), -0.3) @ u[k]
        assert np.allclose(inertia_powers(spectrum, u, 0.3)[k, 0], expected, rtol=1e-10)
    assert np.array_equal(inertia_powers(spectrum, u, 0.0)[:, 0], u)


def test_blocks_threads_and_floats_give_the_same_numbers() -> None:
    system = CHAINS["uniform"]
    q = np.random.default_rng(3).uniform(-1, 1, (9000, 4))
    u, p = np.random.default_rng(4).standard_normal((9000, 4)), np.linspace(0, 1, 11)
    one = inertia_powers(inertia_spectrum(system, q, workers=1), u, p, workers=1)
    spectrum = inertia_spectrum(system, q, workers=2)
    assert np.array_equal(one, inertia_powers(spectrum, u, p, workers=2))
    assert "9000 states" in str(spectrum)
    blocks: list[tuple[int, np.ndarray]] = []
    nothing = inertia_powers(spectrum, u, p, receive=lambda first, block: blocks.append((first, block)))
    assert nothing.size == 0 and [first for first, _ in blocks] == sorted(first for first, _ in blocks)
    assert np.array_equal(np.concatenate([block for _, block in blocks]), one)
    assert np.array_equal(inertia_powers(spectrum, u, p, dtype=np.float32), one.astype(np.float32))


def test_many_turns_cost_no_digits() -> None:
    # cos and sin are exact at 1e6 rad; a sum of such angles would be wrong by 1e-10.
    system, turns = CHAINS["uniform"], np.array([[1e6, -1e6 + 0.25, 3e5, 0.7]])
    expected = exact_powers(system, turns[0], np.ones(4), [0.5])[0].astype(float)
    found = inertia_powers(inertia_spectrum(system, turns), np.ones((1, 4)), 0.5)[0, 0]
    assert np.max(np.abs(found - expected)) < 1e-14 * np.max(np.abs(expected))


def test_runtime_parameters_come_from_the_call_or_the_system() -> None:
    folded, runtime = chain([1, 2], [1, 0.5], [0.5, 0.4]), chain([1, 2], [1, 0.5], [0.5, 0.4], runtime=True)
    q = np.array([[0.3, 0.4]])
    assert np.array_equal(inertia_factor(runtime, q), inertia_factor(folded, q))
    heavier = inertia_factor(runtime, q, {"mass": [4.0, 8.0]})
    assert np.allclose(heavier, 2.0 * inertia_factor(folded, q))


@pytest.mark.parametrize("angles", ["relative", "absolute", "adjacent"])
def test_joint_map_is_that_of_the_scenes_angles(angles: str) -> None:
    assert np.array_equal(joint_map(angles, 5), angle_map(5, angles))


def test_bad_input_is_one_clear_error() -> None:
    system, q, u = CHAINS["uniform"], np.zeros((2, 4)), np.ones((2, 4))
    spatial = System("s", "spatial", "fixed", 1, 3, 3, 0)
    with pytest.raises(UnsupportedError, match="second integral is not q"):
        inertia_spectrum(spatial, np.zeros((1, 3)))
    with pytest.raises(ArrayError, match=r"\(states, 4\)"):
        inertia_spectrum(system, np.zeros((2, 3)))
    with pytest.raises(SignalError, match="not finite"):
        inertia_spectrum(system, np.full((2, 4), np.nan))
    spectrum = inertia_spectrum(system, q)
    with pytest.raises(ArrayError, match="one vector per state"):
        inertia_powers(spectrum, u[:1], 0.5)
    with pytest.raises(SignalError, match="not finite"):
        inertia_powers(spectrum, u * np.inf, 0.5)
    with pytest.raises(SignalError, match="finite real numbers"):
        inertia_powers(spectrum, u, [0.5, np.nan])
    with pytest.raises(ArrayError, match="real numbers"):
        inertia_powers(spectrum, u, 0.5j)
    with pytest.raises(ArrayError, match="M >= n"):
        factor_spectrum(np.ones((1, 2, 3)))
    with pytest.raises(ConvergenceError, match="full rank"):
        factor_spectrum(np.zeros((1, 3, 2)))
    with pytest.raises(ArrayError, match="holds no value"):
        inertia_factor(System("s", "planar", "fixed", 1, 1, 1, 0), [0.0])
