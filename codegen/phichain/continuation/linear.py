"""Linear algebra of a few rows, straight from LAPACK: NumPy's own wrappers cost ten times what they wrap at this size."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.lapack import dgeev, dgeqrf, dgesdd, dgesv, dgetrf, dorgqr, dpotrf

from phichain.system import Vector


def solve(matrix: Vector, right: Vector) -> Vector:
    """A^-1 b, with one right side (n,) or several (n, k).

    Raises:
        LinAlgError: A is singular.
    """
    _, _, found, failed = dgesv(matrix, right)
    if failed:
        raise np.linalg.LinAlgError("singular matrix")
    solution: Vector = found
    return solution


def bordered(rows: Vector, last: Vector) -> Vector:
    """A matrix (n, n + 1) with one more row."""
    whole = np.empty((len(rows) + 1, len(last)))
    whole[:-1], whole[-1] = rows, last
    return whole


def sign_of_determinant(matrix: Vector) -> float:
    """-1, 0 or 1; NaN where the matrix is no numbers."""
    factors, pivots, _ = dgetrf(matrix)
    sign = 1.0
    for k, (entry, pivot) in enumerate(zip(factors.diagonal().tolist(), pivots.tolist(), strict=True)):
        if entry == 0 or math.isnan(entry):
            return entry
        sign = -sign if (entry < 0) != (pivot != k) else sign
    return sign


def least_singular_value(matrix: Vector) -> float:
    """The smallest singular value of a square matrix.

    Raises:
        LinAlgError: It is no numbers.
    """
    _, values, _, failed = dgesdd(matrix, compute_uv=0)
    if failed:
        raise np.linalg.LinAlgError("SVD did not converge")
    return float(values[-1])


def eigenvalues(matrix: Vector) -> NDArray[np.complex128]:
    """Eigenvalues of a real square matrix.

    Raises:
        LinAlgError: It is no numbers, or they were not found.
    """
    if not are_finite(matrix):
        raise np.linalg.LinAlgError("no numbers")
    if len(matrix) == 1:
        return matrix[0].astype(complex)
    real, imaginary, _, _, failed = dgeev(matrix, compute_vl=0, compute_vr=0)
    if failed:
        raise np.linalg.LinAlgError("eigenvalues did not converge")
    return np.asarray(real + 1j * imaginary)


def null_vector(matrix: Vector) -> Vector:
    """The unit vector (n + 1,) across the rows of an (n, n + 1) matrix: the last column of Q in A^T = Q R."""
    rows, columns = matrix.shape
    whole = np.zeros((columns, columns), order="F")
    reflections, tau, _, _ = dgeqrf(matrix.T)
    whole[:, :rows] = reflections
    q, _, _ = dorgqr(whole, tau)
    null: Vector = q[:, -1]
    return null


def size(vector: Vector) -> float:
    """The Euclidean norm."""
    return math.sqrt(vector @ vector)


def are_finite(array: Vector) -> bool:
    """Whether all entries are finite, and the sum of their squares."""
    flat = array.ravel()
    return math.isfinite(flat @ flat)


def cholesky(matrix: Vector) -> Vector:
    """L with A = L L^T.

    Raises:
        LinAlgError: A is not positive definite.
    """
    root, failed = dpotrf(matrix, lower=1)
    if failed:
        raise np.linalg.LinAlgError("matrix is not positive definite")
    lower: Vector = root
    return lower
