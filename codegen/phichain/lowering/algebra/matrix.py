"""Square matrices of Program scalars, as tuples of rows: what planar and spatial chains share."""

from __future__ import annotations

from collections.abc import Sequence

from phichain.ir.builder import ArrayRef, Builder, Expr, Index, Number
from phichain.lowering.algebra.vector import Vector, add, dot, multiple, scale, sub, zeros

Matrix = tuple[Vector, ...]


def zero(builder: Builder, size: int = 3) -> Matrix:
    """All entries structurally zero."""
    return (zeros(builder, size),) * size


def scalar(value: Expr, size: int = 3) -> Matrix:
    """value I"""
    nothing = value.builder.lift(0)
    return tuple(tuple(value if i == j else nothing for j in range(size)) for i in range(size))


def flat(matrix: Matrix) -> Sequence[Expr]:
    """The entries, row by row."""
    return [entry for row in matrix for entry in row]


def from_flat(entries: Sequence[Expr], size: int = 3) -> Matrix:
    """The inverse of `flat`."""
    return tuple(tuple(entries[i : i + size]) for i in range(0, size * size, size))


def load_matrix(array: ArrayRef, k: Index, size: int = 3) -> Matrix:
    """The k-th matrix of an array of matrices."""
    return from_flat([array[size * size * k + i] for i in range(size * size)], size)


def store_matrix(array: ArrayRef, k: Index, value: Matrix) -> None:
    """Write the k-th matrix."""
    entries = flat(value)
    for i, entry in enumerate(entries):
        array[len(entries) * k + i] = entry


def plus(*matrices: Matrix) -> Matrix:
    """Their sum."""
    total = matrices[0]
    for matrix in matrices[1:]:
        total = tuple(add(a, b) for a, b in zip(total, matrix, strict=True))
    return total


def minus(a: Matrix, b: Matrix) -> Matrix:
    """a - b"""
    return tuple(sub(x, y) for x, y in zip(a, b, strict=True))


def scaled(factor: Expr | Number, matrix: Matrix) -> Matrix:
    """factor * matrix"""
    return tuple(scale(factor, row) for row in matrix)


def applied(matrix: Matrix, a: Vector) -> Vector:
    """matrix a"""
    return tuple(dot(row, a) for row in matrix)


def transposed(matrix: Matrix) -> Matrix:
    """matrix^T"""
    return tuple(zip(*matrix, strict=True))


def product(a: Matrix, b: Matrix) -> Matrix:
    """a b"""
    columns = transposed(b)
    return tuple(tuple(dot(row, column) for column in columns) for row in a)


def outer(a: Vector, b: Vector) -> Matrix:
    """a b^T"""
    return tuple(multiple(x, b) for x in a)


def hat(builder: Builder, a: Vector) -> Matrix:
    """The matrix of a x in space."""
    x, y, z = a
    nothing = builder.lift(0)
    return (nothing, -z, y), (z, nothing, -x), (-y, x, nothing)


def combined(factor: Expr | Number, matrix: Matrix, diagonal: Expr | Number) -> Matrix:
    """factor * matrix + diagonal * I"""
    return tuple(
        tuple(factor * entry + diagonal if i == j else factor * entry for j, entry in enumerate(row))
        for i, row in enumerate(matrix)
    )


def trace(matrix: Matrix) -> Expr:
    """Sum of the diagonal."""
    total = matrix[0][0]
    for i, row in enumerate(matrix[1:], 1):
        total = total + row[i]
    return total


def complement(matrix: Matrix) -> Matrix:
    """tr(A) I - A, its diagonal formed without subtracting."""
    rows = []
    for i, row in enumerate(matrix):
        others = [matrix[j][j] for j in range(len(matrix)) if j != i]
        total = others[0]
        for entry in others[1:]:
            total = total + entry
        rows.append(tuple(total if i == j else -entry for j, entry in enumerate(row)))
    return tuple(rows)


def adjugate(matrix: Matrix) -> Matrix:
    """The adjugate of a 1 x 1 or 2 x 2 matrix, which has the entries of the matrix."""
    if len(matrix) == 1:
        return ((matrix[0][0].builder.lift(1),),)
    (a, b), (c, d) = matrix
    return (d, -b), (-c, a)


# --- symmetric ones: only the upper triangle is computed --------------------------------------------------------------

_UPPER = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))


def symmetric(upper: Sequence[Expr]) -> Matrix:
    """The symmetric 3 x 3 matrix with (xx, xy, xz, yy, yz, zz)."""
    xx, xy, xz, yy, yz, zz = upper
    return (xx, xy, xz), (xy, yy, yz), (xz, yz, zz)


def triangle(matrix: Matrix) -> Vector:
    """(xx, xy, xz, yy, yz, zz) of a symmetric 3 x 3 matrix."""
    return tuple(matrix[i][j] for i, j in _UPPER)


def combine(*terms: tuple[Expr | Number, Matrix]) -> Matrix:
    """Linear combination of symmetric matrices."""
    entries = []
    for i, j in _UPPER:
        total = terms[0][1][i][j] * terms[0][0]
        for factor, matrix in terms[1:]:
            total = total + matrix[i][j] * factor
        entries.append(total)
    return symmetric(entries)


def dyads(*vectors: Vector) -> Matrix:
    """The sum of dyads a b^T + c d^T + ..., known to be symmetric, from its upper triangle."""
    entries = []
    for i, j in _UPPER:
        total = vectors[0][i] * vectors[1][j]
        for a, b in zip(vectors[2::2], vectors[3::2], strict=True):
            total = total + a[i] * b[j]
        entries.append(total)
    return symmetric(entries)


def cofactors(matrix: Matrix) -> Matrix:
    """The adjugate of a symmetric 3 x 3 matrix."""
    xx, xy, xz, yy, yz, zz = triangle(matrix)
    return symmetric(
        (yy * zz - yz * yz, xz * yz - xy * zz, xy * yz - xz * yy, xx * zz - xz * xz, xy * xz - xx * yz, xx * yy - xy * xy)
    )


# --- across a unit vector ---------------------------------------------------------------------------------------------


def across_rows(matrix: Matrix, q: Vector) -> Matrix:
    """(I - q q^T) matrix, q a unit vector."""
    along = tuple(dot(q, column) for column in transposed(matrix))
    return tuple(tuple(x - part * y for x, y in zip(row, along, strict=True)) for row, part in zip(matrix, q, strict=True))


def across_columns(matrix: Matrix, q: Vector) -> Matrix:
    """matrix (I - q q^T), q a unit vector."""
    along = applied(matrix, q)
    return tuple(tuple(x - y * part for x, part in zip(row, q, strict=True)) for row, y in zip(matrix, along, strict=True))


def tangent_inverse(matrix: Matrix, q: Vector) -> Matrix:
    """The inverse on the plane across q of a matrix that maps this plane onto itself and q to nothing.

    In two dimensions adj(M) = tr(M) I - M; the determinant is the sum of the principal minors.
    """
    (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = matrix
    total = trace(matrix)
    determinant = (xx * yy - xy * yx) + (xx * zz - xz * zx) + (yy * zz - yz * zy)
    inverse = total.builder.let("inverse_pivot", 1 / determinant)
    return scaled(inverse, minus(across_rows(scalar(total), q), matrix))
