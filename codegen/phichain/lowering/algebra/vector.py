"""Three-vectors of Program scalars."""

from __future__ import annotations

from phichain.ir.builder import ArrayRef, Expr, Index, Number

Vector = tuple[Expr, Expr, Expr]
#: Symmetric 3 x 3 matrix as (xx, xy, xz, yy, yz, zz).
Symmetric = tuple[Expr, Expr, Expr, Expr, Expr, Expr]


def load(array: ArrayRef, k: Index) -> Vector:
    """The k-th vector of an array of vectors."""
    return array[3 * k], array[3 * k + 1], array[3 * k + 2]


def store(array: ArrayRef, k: Index, value: Vector) -> None:
    """Write the k-th vector."""
    for i in range(3):
        array[3 * k + i] = value[i]


def dot(a: Vector, b: Vector) -> Expr:
    """a . b"""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Vector, b: Vector) -> Vector:
    """a x b"""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def add(a: Vector, b: Vector) -> Vector:
    """a + b"""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


def sub(a: Vector, b: Vector) -> Vector:
    """a - b"""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def scale(factor: Expr | Number, a: Vector) -> Vector:
    """factor * a"""
    return a[0] * factor, a[1] * factor, a[2] * factor


def times(matrix: Symmetric, a: Vector) -> Vector:
    """Symmetric matrix times vector."""
    xx, xy, xz, yy, yz, zz = matrix
    return dot((xx, xy, xz), a), dot((xy, yy, yz), a), dot((xz, yz, zz), a)


def combine(*terms: tuple[Expr | Number, Symmetric]) -> Symmetric:
    """Linear combination of symmetric matrices."""
    entries = []
    for i in range(6):
        total = terms[0][1][i] * terms[0][0]
        for factor, matrix in terms[1:]:
            total = total + matrix[i] * factor
        entries.append(total)
    return entries[0], entries[1], entries[2], entries[3], entries[4], entries[5]


def upper(*vectors: Vector) -> Symmetric:
    """The sum of dyads a b^T + c d^T + ..., known to be symmetric, from its upper triangle."""
    entries = []
    for i, j in ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)):
        total = vectors[0][i] * vectors[1][j]
        for a, b in zip(vectors[2::2], vectors[3::2], strict=True):
            total = total + a[i] * b[j]
        entries.append(total)
    return entries[0], entries[1], entries[2], entries[3], entries[4], entries[5]
