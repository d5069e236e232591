"""The little linear algebra of the reference, on plain lists of mpf (faster than `mpmath.matrix`)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from mpmath import fdot, mp, mpf

Vector = list[Any]
Matrix = list[Vector]


def solve(matrix: Matrix, right_sides: Matrix) -> Matrix:
    """Return the solutions of matrix x = b for several right sides b, by LU with partial pivoting."""
    size = len(matrix)
    rows = [list(row) + [side[i] for side in right_sides] for i, row in enumerate(matrix)]
    for k in range(size):
        best = max(range(k, size), key=lambda i: abs(rows[i][k]))
        rows[k], rows[best] = rows[best], rows[k]
        for i in range(k + 1, size):
            factor = rows[i][k] / rows[k][k]
            if factor:
                rows[i][k:] = [a - factor * b for a, b in zip(rows[i][k:], rows[k][k:], strict=True)]
    return [_substituted(rows, side) for side in range(size, size + len(right_sides))]


def _substituted(rows: Matrix, side: int) -> Vector:
    """Return the solution of the triangular system whose right side stands in column `side`."""
    size = len(rows)
    x: Vector = [mpf(0)] * size
    for k in reversed(range(size)):
        x[k] = (rows[k][side] - fdot(rows[k][k + 1 : size], x[k + 1 :])) / rows[k][k]
    return x


def dot(a: Sequence[Any], b: Sequence[Any]) -> Any:
    """Return a.b of short vectors, for which this is faster than `fdot`."""
    products = [x * y for x, y in zip(a, b, strict=True)]
    return sum(products[1:], products[0])


def cross(a: Sequence[Any], b: Sequence[Any]) -> Vector:
    """Return a x b in R^3."""
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def unit(size: int, index: int) -> Vector:
    """Return the unit vector e_index (counted from 0) of R^size."""
    return [mpf(int(i == index)) for i in range(size)]


def moved(start: Sequence[Any], direction: Sequence[Any], distance: Any) -> Vector:
    """Return start + distance * direction."""
    return [a + distance * b for a, b in zip(start, direction, strict=True)]


def transposed(matrix: Matrix) -> Matrix:
    """Return the transpose."""
    return [list(column) for column in zip(*matrix, strict=True)]


def tangent_axes(link: Sequence[Any]) -> Matrix:
    """Return two orthonormal vectors orthogonal to a unit vector of R^3."""
    helper = min((unit(3, i) for i in range(3)), key=lambda axis: abs(fdot(axis, link)))
    first = cross(link, helper)
    size = mp.sqrt(fdot(first, first))
    first = [entry / size for entry in first]
    return [first, cross(link, first)]
