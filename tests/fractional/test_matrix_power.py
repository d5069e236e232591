"""Powers of general matrices against mpmath, group laws and SciPy."""

from __future__ import annotations

import warnings

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.linalg import fractional_matrix_power

from phichain.errors import ArrayError, PhichainError
from phichain.fractional import MatrixPowerError, NearDefectiveWarning, eigenvectors, matrix_power

GENERAL = np.array([[4.0, 1.0, -2.0], [0.5, 3.0, 1.0], [1.0, -1.0, 5.0]])


@pytest.mark.parametrize("p", [0.5, -0.3, 1 / 3, 2.7, 0.4 + 0.9j, -1.2j])
def test_power_agrees_with_mpmath(p: complex) -> None:
    with mpmath.workdps(40):
        logarithm = mpmath.logm(mpmath.matrix(GENERAL.tolist()))
        exact = mpmath.expm(mpmath.mpmathify(p) * logarithm)
        expected = np.array([[complex(exact[i, j]) for j in range(3)] for i in range(3)])
    found = matrix_power(GENERAL, p)
    assert np.max(np.abs(found - expected)) < 5e-15 * np.max(np.abs(expected))
    assert np.isrealobj(found) == (np.imag(p) == 0)


@given(
    arrays(float, (4, 4), elements=st.floats(-1.0, 1.0)),
    st.complex_numbers(max_magnitude=1.5),
    st.complex_numbers(max_magnitude=1.5),
)
def test_exponents_add(noise: np.ndarray, p: complex, q: complex) -> None:
    a = noise + np.diag([3.0, 5.0, 8.0, 13.0])
    product = matrix_power(a, p) @ matrix_power(a, q)
    assert np.allclose(
        product, matrix_power(a, p + q), rtol=0, atol=1e-10 * max(1.0, np.max(np.abs(product)))
    )


@given(arrays(float, (3, 3), elements=st.floats(-2.0, 2.0)), st.floats(-0.9, 0.9))
def test_powers_of_symmetric_positive_matrices_agree_with_scipy(root: np.ndarray, p: float) -> None:
    a = root.T @ root + np.eye(3)
    assert np.allclose(matrix_power(a, p), fractional_matrix_power(a, p), rtol=1e-9, atol=1e-10)


def test_many_exponents_at_once() -> None:
    exponents = np.array([[0.0, 0.5], [1.0, -1.0]])
    powers = matrix_power(GENERAL, exponents)
    assert powers.shape == (2, 2, 3, 3)
    assert np.array_equal(powers[0, 0], np.eye(3)) and np.array_equal(powers[1, 0], GENERAL)
    assert np.allclose(powers[0, 1] @ powers[0, 1], GENERAL, atol=1e-13)
    assert np.allclose(powers[1, 1] @ GENERAL, np.eye(3), atol=1e-14)


def test_negative_eigenvalues_give_complex_powers_and_never_nan() -> None:
    a = np.array([[-4.0, 1.0], [0.0, 9.0]])
    root = matrix_power(a, 0.5)
    assert np.iscomplexobj(root) and np.all(np.isfinite(root)) and np.allclose(root @ root, a, atol=1e-14)
    assert root[0, 0] == pytest.approx(2j) and matrix_power([[-8.0]], 1 / 3)[0, 0] == pytest.approx(
        1 + np.sqrt(3) * 1j
    )
    cube = matrix_power(a, 3)
    assert np.isrealobj(cube) and np.array_equal(cube, a @ a @ a)


def test_near_defective_matrix_warns_and_takes_schur_pade() -> None:
    gap = 1e-9
    a = np.array([[1.0, 1.0], [0.0, 1.0 + gap]])
    # The off-diagonal entry of the power is the divided difference of x^p.
    expected = ((1.0 + gap) ** 0.5 - 1.0) / gap
    with pytest.warns(NearDefectiveWarning, match="cond V = 2e"):
        found = matrix_power(a, 0.5)
    assert found[0, 1] == pytest.approx(0.5, rel=1e-9) and expected == pytest.approx(0.5, rel=1e-6)
    with pytest.warns(NearDefectiveWarning, match="the former is returned, as asked"):
        asked = matrix_power(a, 0.5, method="eigenvectors")
    assert np.allclose(asked, found, rtol=1e-5)


def test_well_conditioned_matrix_does_not_warn() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        matrix_power(GENERAL, 0.5)
    assert eigenvectors(GENERAL @ GENERAL.T).condition == 1.0


@pytest.mark.parametrize("p", [0.5, -0.25, 0.5 + 1.0j])
def test_defective_matrix_is_refused_but_for_schur_pade(p: complex) -> None:
    a = [[2.0, 1.0], [0.0, 2.0]]
    with pytest.raises(MatrixPowerError, match='is defective.*method="schur"'):
        matrix_power(a, p)
    assert np.allclose(
        matrix_power(a, p, method="schur"), [[2.0**p, p * 2.0 ** (p - 1)], [0, 2.0**p]], rtol=1e-13
    )
    assert np.array_equal(matrix_power(a, 2), [[4.0, 4.0], [0.0, 4.0]])


SINGULAR = [
    (np.array([[1.0, 0, 0, 1], [0, 0, 0, 0], [0, 0, 0, 0], [1, 0, 0, 1]]), np.sqrt(0.5)),
    (np.ones((3, 3)), 1 / np.sqrt(3)),
    (np.zeros((3, 3)), 1.0),
    (np.outer([1, 2, 3], [3, 1, 0.5]), 1 / np.sqrt(6.5)),
]
"""Matrices with A^2 = A / c^2: their root is c A."""


@pytest.mark.parametrize("method", ["auto", "eigenvectors", "schur"])
@pytest.mark.parametrize(("a", "factor"), SINGULAR)
def test_a_semisimple_zero_has_powers(a: np.ndarray, factor: float, method: str) -> None:
    found = matrix_power(a, [0.5, 0, 1, 2], method=method)
    assert np.isrealobj(found)
    assert np.max(np.abs(found[0] - factor * a)) < 1e-14
    assert np.array_equal(found[1], np.eye(len(a))) and np.array_equal(found[2], a)


@pytest.mark.parametrize("method", ["auto", "schur"])
@pytest.mark.parametrize("p", [0.5, 0.3, 1.7, 0.5 + 2j])
def test_powers_beside_a_zero_are_those_of_the_rest(p: complex, method: str) -> None:
    """A = X diag(0, 0, lambda) X^-1 with everything exact in 40 digits."""
    rng = np.random.default_rng(5)
    x, values = rng.integers(-3, 4, (5, 5)) + 7 * np.eye(5), [0, 0, 2, 3, 0.5]
    with mpmath.workdps(40):
        left = mpmath.matrix(x.tolist())
        right = left**-1
        a = np.array((left * mpmath.diag(values) * right).tolist(), dtype=float)
        power = left * mpmath.diag([mpmath.mpf(v) ** mpmath.mpmathify(p) if v else 0 for v in values]) * right
        expected = np.array([[complex(power[i, j]) for j in range(5)] for i in range(5)])
    assert np.max(np.abs(matrix_power(a, p, method=method) - expected)) < 1e-13 * np.max(np.abs(expected))


def test_a_zero_beside_a_jordan_block_leaves_the_block_its_power() -> None:
    a = np.zeros((4, 4))
    a[:2, :2] = [[4.0, 1.0], [0.0, 4.0]]
    turn = np.linalg.qr(np.random.default_rng(2).normal(size=(4, 4)))[0]
    found = turn.T @ matrix_power(turn @ a @ turn.T, 0.5, method="schur") @ turn
    assert np.allclose(found[:2, :2], [[2.0, 0.25], [0.0, 2.0]], atol=1e-13)
    assert np.max(np.abs(found[2:])) < 1e-13
    with pytest.warns(NearDefectiveWarning, match="the latter is returned"):
        assert np.allclose(matrix_power(a, 0.5)[:2, :2], [[2.0, 0.25], [0.0, 2.0]], atol=1e-13)


def test_a_zero_keeps_small_eigenvalues_beside_it() -> None:
    found = matrix_power(np.diag([0.0, 1.0, 1e-20, -4.0]), 0.5)
    assert np.allclose(found, np.diag([0.0, 1.0, 1e-10, 2j]), rtol=1e-15)


@pytest.mark.parametrize("method", ["auto", "eigenvectors", "schur"])
@pytest.mark.parametrize("turned", [False, True])
def test_a_nilpotent_part_is_refused(turned: bool, method: str) -> None:
    a = np.diag([0.0, 0.0, 0.0, 5.0])
    a[0, 1] = 1.0
    if turned:
        turn = np.linalg.qr(np.random.default_rng(3).normal(size=(4, 4)))[0]
        a = turn @ a @ turn.T
    for matrix in (a, np.array([[0.0, 1.0], [0.0, 0.0]])):
        with pytest.raises(MatrixPowerError, match="singular to working precision.*too few eigenvectors"):
            matrix_power(matrix, 0.5, method=method)
        assert np.array_equal(matrix_power(matrix, 2), matrix @ matrix)


@pytest.mark.parametrize("a", [matrix for matrix, _ in SINGULAR])
def test_a_singular_matrix_has_no_inverse_powers(a: np.ndarray) -> None:
    for p in (-0.5, -1, 0.5j, [0.5, -1]):
        with pytest.raises(MatrixPowerError, match="singular to working precision.*Re p <= 0"):
            matrix_power(a, p)
    assert np.array_equal(matrix_power(a, 2), a @ a)


def test_small_but_certain_eigenvalues_are_kept() -> None:
    assert np.allclose(matrix_power(np.diag([1.0, 1e-20]), -0.5), np.diag([1.0, 1e10]), rtol=1e-14)


@pytest.mark.parametrize(
    ("a", "p", "options"),
    [
        (np.ones((2, 3)), 0.5, {}),
        ([1.0, 2.0], 0.5, {}),
        (np.empty((0, 0)), 0.5, {}),
        ([["a"]], 0.5, {}),
        ([[1.0], [1.0, 2.0]], 0.5, {}),
        ([[2.0]], [0.5, [0.5]], {}),
        ([[np.nan]], 0.5, {}),
        ([[2.0]], np.inf, {}),
        ([[2.0]], "half", {}),
        ([[2.0]], 0.5, {"method": "magic"}),
    ],
)
def test_bad_input_is_one_clear_error(a: object, p: object, options: dict) -> None:
    with pytest.raises(ArrayError) as caught:
        matrix_power(a, p, **options)  # type: ignore[arg-type]
    assert isinstance(caught.value, PhichainError) and ";" in str(caught.value)


def test_overflow_is_said() -> None:
    with pytest.raises(MatrixPowerError, match="overflows"), np.errstate(all="ignore"):
        matrix_power([[1e200]], 2.5)
