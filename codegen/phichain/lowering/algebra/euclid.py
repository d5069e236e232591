"""Vectors and square matrices of Program scalars in two or three dimensions: what planar and spatial chains share.

A planar chain is a chain of unit vectors too, q = (sin phi, cos phi); code written with these serves both.
"""

from __future__ import annotations

from collections.abc import Sequence

from phichain.ir.builder import ArrayRef, Builder, Expr, Index, Number
from phichain.scene import Scene

Vector = tuple[Expr, ...]
#: Rows of a square matrix.
Matrix = tuple[Vector, ...]


def dimension(scene: Scene) -> int:
    """Number of components of a unit vector: 2 in the plane, 3 in space."""
    return 2 if scene.is_planar else 3


def cart_size(scene: Scene) -> int:
    """Number of the cart's coordinates: 0, 1 (planar) or 2 (spatial)."""
    return dimension(scene) - 1 if scene.has_cart else 0


def ambient_size(scene: Scene) -> int:
    """Cells of [x, q_1 .. q_N] with unit vectors in the plane as well."""
    return cart_size(scene) + dimension(scene) * scene.links


def load(array: ArrayRef, k: Index, size: int) -> Vector:
    """The k-th vector of an array of vectors."""
    return tuple(array[size * k + i] for i in range(size))


def store(array: ArrayRef, k: Index, value: Vector) -> None:
    """Write the k-th vector."""
    for i, entry in enumerate(value):
        array[len(value) * k + i] = entry


def dot(a: Vector, b: Vector) -> Expr:
    """a . b"""
    total = a[0] * b[0]
    for x, y in zip(a[1:], b[1:], strict=True):
        total = total + x * y
    return total


def add(a: Vector, b: Vector) -> Vector:
    """a + b"""
    return tuple(x + y for x, y in zip(a, b, strict=True))


def sub(a: Vector, b: Vector) -> Vector:
    """a - b"""
    return tuple(x - y for x, y in zip(a, b, strict=True))


def scale(factor: Expr | Number, a: Vector) -> Vector:
    """factor * a"""
    return tuple(factor * x for x in a)


def wedge(a: Vector, b: Vector) -> Vector:
    """a ^ b: the cross product in space, its one component in the plane; (a ^ b).(c ^ d) = (a.c)(b.d) - (a.d)(b.c)."""
    if len(a) == 2:
        return (a[0] * b[1] - a[1] * b[0],)
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def down(builder: Builder, size: int, value: Expr | Number = 1) -> Vector:
    """value * e_d, along gravity."""
    return (*zeros(builder, size - 1), builder.lift(value))


def zeros(builder: Builder, size: int) -> Vector:
    """The zero vector."""
    return (builder.lift(0),) * size


def named(builder: Builder, label: str, value: Vector) -> Vector:
    """Give every component a name in the emitted text."""
    return tuple(builder.let(f"{label}_{axis}", x) for axis, x in zip("xyz", value, strict=False))


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


def hat(builder: Builder, a: Vector) -> Matrix:
    """The matrix of a x in space."""
    x, y, z = a
    nothing = builder.lift(0)
    return (nothing, -z, y), (z, nothing, -x), (-y, x, nothing)


def outer(a: Vector, b: Vector) -> Matrix:
    """a b^T"""
    return tuple(scale(x, b) for x in a)


def summed(a: Matrix, b: Matrix) -> Matrix:
    """a + b"""
    return tuple(add(x, y) for x, y in zip(a, b, strict=True))


def flat(matrix: Matrix) -> Sequence[Expr]:
    """The entries, row by row."""
    return [entry for row in matrix for entry in row]
