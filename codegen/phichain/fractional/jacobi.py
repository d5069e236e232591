"""Singular values of many small matrices at once, each to high relative accuracy: one-sided Jacobi after a pivoted QR.

A chain's inertia matrix is I = F^T F with F = D B: the square roots of the masses scale the ROWS of the positions'
Jacobian B. Where masses spread over decades an eigendecomposition of I finds the large eigenvalues alone (error eps
times the largest). F itself still holds the small ones:

1. rows sorted by size, then QR with column pivoting, F P = Q R: stable row by row, and R is graded again, D' R';
2. where the coordinates are a linear map of those of F (a chain's angles, phi = S theta), Y = R P^T S row by row;
3. one-sided Jacobi on the columns of X = Y^T = (R' P^T S)^T D': each rotation changes columns by relative round-off
   only, so the error is eps times the condition number of R' P^T S, whatever D'. X -> U diag(sigma);
4. F S = (Q ..) diag(sigma) U^T: the columns of U are the right singular vectors. Nothing is accumulated, and the left
   vectors are never made.

The map comes after the QR because its sums would bury short links under long ones.

Sources: Z. Drmac and K. Veselic, New fast and accurate Jacobi SVD algorithm, SIAM J. Matrix Anal. Appl. 29 (2008)
1322-1362 (LAPACK's xGEJSV); A. J. Cox and N. J. Higham, Stability of Householder QR for weighted least squares (1998).

Arrays are structures of arrays: the states run along the last axis, and every line below works on all of them.
"""

from __future__ import annotations

from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from phichain.errors import ConvergenceError

Vector = NDArray[np.float64]

_EPS = float(np.finfo(float).eps)
# Quadratic convergence takes 4 to 6 sweeps; more than this means the input was not finite.
_SWEEPS = 40


def right_singular_system(factor: Vector, relation: Vector | None = None) -> tuple[Vector, Vector]:
    """Singular values and right singular vectors of S matrices F S, so that (F S)^T F S = V diag(sigma^2) V^T.

    Args:
        factor: F, shape (M, N, states) with M >= N, of full column rank.
        relation: S, shape (N, N), a matrix of zeros and ones; None stands for the identity.

    Returns:
        sigma, shape (N, states), in no particular order, and V, shape (N, N, states), its second axis along sigma.

    Raises:
        ConvergenceError: A matrix is not finite or has a zero singular value.
    """
    columns = _pivoted_qr(factor)
    if relation is not None:
        columns = np.stack([np.sum(columns[:, source != 0.0], axis=1) for source in relation.T], axis=1)
    _orthogonalise(columns)
    sigma = np.sqrt(np.sum(columns * columns, axis=1))
    if not np.all(sigma > 0.0):
        raise ConvergenceError(
            "factor",
            factor,
            "is not of full rank or not finite in some state",
            "check masses, lengths and states",
        )
    columns /= sigma[:, None, :]
    return sigma, columns.swapaxes(0, 1)


def _pivoted_qr(factor: Vector) -> Vector:
    """R P^T of F P = Q R, the rows of F sorted by size first; row i is column i of X = (R P^T)^T."""
    rows, columns, states = factor.shape
    order = np.argsort(-np.max(np.abs(factor), axis=1), axis=0, kind="stable")
    work = np.take_along_axis(factor, order[:, None, :], axis=0)
    permutation = np.tile(np.arange(columns)[:, None], (1, states))
    for k in range(columns):
        _bring_largest_column_first(work, permutation, k)
        if k < rows - 1:
            _reflect(work[k:, k:])
    triangle = work[:columns]
    for k in range(1, columns):
        triangle[k, :k] = 0.0
    result = np.empty_like(triangle)
    np.put_along_axis(result, permutation[None, :, :], triangle, axis=1)
    return result


def _bring_largest_column_first(work: Vector, permutation: NDArray[np.intp], k: int) -> None:
    """Swap the column of largest remaining norm into place k, state by state."""
    remaining = work[k:, k:]
    pivot = k + np.argmax(np.einsum("ijs,ijs->js", remaining, remaining), axis=0)
    index = np.broadcast_to(pivot[None, None, :], (work.shape[0], 1, pivot.size))
    chosen = np.take_along_axis(work, index, axis=1)
    np.put_along_axis(work, index, work[:, k : k + 1].copy(), axis=1)
    work[:, k : k + 1] = chosen
    label = np.take_along_axis(permutation, pivot[None, :], axis=0)
    np.put_along_axis(permutation, pivot[None, :], permutation[k : k + 1].copy(), axis=0)
    permutation[k : k + 1] = label


def _reflect(block: Vector) -> None:
    """Householder reflection of the block that turns its first column into a multiple of e_1."""
    norm = np.sqrt(np.einsum("is,is->s", block[:, 0], block[:, 0]))
    head = block[0, 0]
    target = -np.copysign(norm, head)
    direction = block[:, 0].copy()
    direction[0] -= target
    # |direction|^2 / 2 without cancellation, as head and target have opposite signs.
    half_square = norm * (norm + np.abs(head))
    half_square[half_square == 0.0] = 1.0
    for column in range(1, block.shape[1]):
        scale = np.einsum("is,is->s", direction, block[:, column]) / half_square
        block[:, column] -= direction * scale
    block[0, 0] = target


def _orthogonalise(columns: Vector) -> None:
    """Rotate pairs of columns[i] (N, S) until all are orthogonal to working precision, in place."""
    count = columns.shape[0]
    tolerance = count * _EPS
    for _ in range(_SWEEPS):
        squares = np.einsum("kis,kis->ks", columns, columns)
        rotated = [_rotate(columns, squares, p, q, tolerance) for p, q in combinations(range(count), 2)]
        if not any(rotated):
            return
    raise ConvergenceError(
        "factor", columns, "has no singular values to be found", "check that the states are finite"
    )


def _rotate(columns: Vector, squares: Vector, p: int, q: int, tolerance: float) -> bool:
    """One Jacobi rotation of columns p and q in every state; False when none needed it."""
    product = np.einsum("is,is->s", columns[p], columns[q])
    # A square updated to just below zero is recomputed in the next sweep.
    needed = np.abs(product) > tolerance * np.sqrt(np.abs(squares[p] * squares[q]))
    if not np.any(needed):
        return False
    # tan of the rotation angle, |t| <= 1: t^2 + 2 zeta t - 1 = 0 with zeta = (b - a) / (2 c).
    difference = 0.5 * (squares[q] - squares[p])
    root = np.sqrt(difference * difference + product * product)
    with np.errstate(divide="ignore", invalid="ignore"):
        tangent = np.where(needed, product / (difference + np.copysign(root, difference)), 0.0)
    cosine = 1.0 / np.sqrt(1.0 + tangent * tangent)
    sine = cosine * tangent
    shift = tangent * product
    squares[p] -= shift
    squares[q] += shift
    left = cosine * columns[p]
    left -= sine * columns[q]
    columns[q] *= cosine
    columns[q] += sine * columns[p]
    columns[p] = left
    return True
