"""3 x 3 matrices of Program scalars, row-major tuples of nine."""

from __future__ import annotations

from phichain.ir.builder import ArrayRef, Builder, Expr, Index, Number
from phichain.lowering.algebra.vector import Vector, dot

Matrix = tuple[Expr, ...]


def zero(builder: Builder) -> Matrix:
    """All entries structurally zero."""
    return (builder.lift(0),) * 9


def scalar(value: Expr) -> Matrix:
    """value I"""
    nothing = value.builder.lift(0)
    return tuple(value if i == j else nothing for i in range(3) for j in range(3))


def load_matrix(array: ArrayRef, k: Index) -> Matrix:
    """The k-th matrix of an array of matrices."""
    return tuple(array[9 * k + i] for i in range(9))


def store_matrix(array: ArrayRef, k: Index, value: Matrix) -> None:
    """Write the k-th matrix."""
    for i in range(9):
        array[9 * k + i] = value[i]


def plus(*matrices: Matrix) -> Matrix:
    """Their sum."""
    total = matrices[0]
    for matrix in matrices[1:]:
        total = tuple(a + b for a, b in zip(total, matrix, strict=True))
    return total


def minus(a: Matrix, b: Matrix) -> Matrix:
    """a - b"""
    return tuple(x - y for x, y in zip(a, b, strict=True))


def scaled(factor: Expr | Number, matrix: Matrix) -> Matrix:
    """factor * matrix"""
    return tuple(entry * factor for entry in matrix)


def product(a: Matrix, b: Matrix) -> Matrix:
    """a b"""
    return tuple(
        a[3 * i] * b[j] + a[3 * i + 1] * b[3 + j] + a[3 * i + 2] * b[6 + j]
        for i in range(3)
        for j in range(3)
    )


def dyad(a: Vector, b: Vector) -> Matrix:
    """a b^T"""
    return tuple(a[i] * b[j] for i in range(3) for j in range(3))


def apply(matrix: Matrix, a: Vector) -> Vector:
    """matrix a"""
    rows = [(matrix[3 * i], matrix[3 * i + 1], matrix[3 * i + 2]) for i in range(3)]
    return dot(rows[0], a), dot(rows[1], a), dot(rows[2], a)


def across_rows(matrix: Matrix, q: Vector) -> Matrix:
    """(I - q q^T) matrix, q a unit vector."""
    along = tuple(q[0] * matrix[j] + q[1] * matrix[3 + j] + q[2] * matrix[6 + j] for j in range(3))
    return tuple(matrix[3 * i + j] - q[i] * along[j] for i in range(3) for j in range(3))


def across_columns(matrix: Matrix, q: Vector) -> Matrix:
    """matrix (I - q q^T), q a unit vector."""
    along = apply(matrix, q)
    return tuple(matrix[3 * i + j] - along[i] * q[j] for i in range(3) for j in range(3))


def tangent_inverse(matrix: Matrix, q: Vector) -> Matrix:
    """The inverse on the plane across q of a matrix that maps this plane onto itself and q to nothing.

    In two dimensions adj(M) = tr(M) I - M; the determinant is the sum of the principal minors.
    """
    m = matrix
    trace = m[0] + m[4] + m[8]
    determinant = (m[0] * m[4] - m[1] * m[3]) + (m[0] * m[8] - m[2] * m[6]) + (m[4] * m[8] - m[5] * m[7])
    inverse = trace.builder.let("inverse_pivot", 1 / determinant)
    return scaled(inverse, minus(across_rows(scalar(trace), q), matrix))
