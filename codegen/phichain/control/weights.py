"""The weights of a linear regulator, checked, and the few lines of linear algebra that control shares."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from phichain.errors import ControlError
from phichain.system import Vector
from phichain.system.arrays import real_numbers

Spectrum = NDArray[np.complex128]


def weight(field: str, value: ArrayLike | None, size: int, *, strict: bool) -> Vector:
    """A symmetric weight matrix (size, size) from nothing, a number, a diagonal or a matrix.

    Args:
        field: "Q" or "R", for messages.
        value: None (identity), a number times the identity, `size` diagonal entries, or the matrix.
        size: Its order.
        strict: True demands a positive definite matrix, False a positive semidefinite one.

    Raises:
        ControlError: Wrong shape, not finite, not symmetric, or not positive.
    """
    given = real_numbers(
        field, 1.0 if value is None else value, "give one number, the diagonal or the matrix"
    )
    if given.ndim == 0:
        given = np.full(size, float(given))
    if given.ndim > 2:
        raise ControlError(field, given.shape, f"must weigh {size} quantities", "give a number, a diagonal or a matrix")
    matrix = np.diag(given) if given.ndim == 1 else given
    if matrix.shape != (size, size):
        raise ControlError(
            field, given.shape, f"must weigh {size} quantities", f"give {size} entries or one number"
        )
    if not np.all(np.isfinite(matrix)):
        raise ControlError(field, given, "is not finite", "give finite weights")
    # Halves cannot overflow where the entries themselves have not.
    if np.max(np.abs(matrix / 2 - matrix.T / 2)) > 1e-12 * np.max(np.abs(matrix / 2)):
        raise ControlError(field, given, "is not symmetric", "give (W + W^T) / 2")
    smallest, largest = np.linalg.eigvalsh(matrix)[[0, -1]]
    # Round-off alone makes a semidefinite matrix's smallest eigenvalue slightly negative.
    bound = 0.0 if strict else -1e-12 * largest
    if largest <= 0 or (smallest <= bound if strict else smallest < bound):
        kind = "positive definite" if strict else "positive semidefinite and not zero"
        raise ControlError(
            field, given, f"must be {kind}: its smallest eigenvalue is {smallest:.3g}", "raise its diagonal"
        )
    return matrix if np.array_equal(matrix, matrix.T) else np.asarray(matrix / 2 + matrix.T / 2, dtype=float)


def spectrum(A: Vector) -> Spectrum:
    """Eigenvalues (n,) of A by falling real part, conjugates together."""
    return ordered(np.linalg.eigvals(A).astype(complex))


def ordered(values: Spectrum) -> Spectrum:
    """Eigenvalues by falling real part, conjugates together."""
    return values[np.lexsort((values.imag, -values.real))]


def solve(matrix: NDArray[Any], right: NDArray[Any]) -> Vector:
    """The solution X of matrix X = right."""
    return np.asarray(np.linalg.solve(matrix, right), dtype=float)
