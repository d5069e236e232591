"""Linear algebra of a few rows, straight from LAPACK: NumPy's own wrappers cost ten times what they wrap at this size."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.lapack import dgeev, dgeqrf, dgesdd, dgesv, dgetrf, dorgqr

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
    swaps = np.count_nonzero(pivots != np.arange(len(pivots)))
    return float(np.prod(np.sign(factors.diagonal()))) * (-1.0 if swaps % 2 else 1.0)


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
    return float(np.sqrt(vector @ vector))


def are_finite(array: Vector) -> bool:
    """Whether all entries are finite, and their sum."""
    return bool(np.isfinite(array.sum()))
