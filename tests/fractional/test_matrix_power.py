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


@pytest.mark.parametrize(
    "a", [np.ones((2, 2)), np.zeros((3, 3)), [[0.0, 1.0], [0.0, 0.0]], np.outer([1, 2, 3], [3, 1, 0.5])]
)
def test_singular_matrix_is_refused(a: object) -> None:
    for p in (0.5, -1, 0.5j):
        with pytest.raises(MatrixPowerError, match="singular to working precision"):
            matrix_power(a, p)
    assert np.array_equal(matrix_power(a, 2), np.asarray(a) @ np.asarray(a))


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
