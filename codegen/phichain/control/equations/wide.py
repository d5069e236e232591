"""Matrices in twice the digits: unevaluated sums of two doubles, about 32 digits on every processor.

Every operation is a chain of rounded double operations whose errors are exact doubles (Dekker 1971): no type of a
particular processor is used, as long double would be.

Source: T. J. Dekker, A floating-point technique for extending the available precision, Numer. Math. 18 (1971) 224-242.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from phichain.records import Held
from phichain.system import Vector

_SPLITTER = 2.0**27 + 1


@dataclass(frozen=True, eq=False)
class Wide(Held):
    """An array high + low, |low| at most half a unit in the last place of high.

    Attributes:
        high: The leading doubles.
        low: What they leave.
    """

    high: Vector
    low: Vector

    __array_ufunc__ = None

    @staticmethod
    def of(values: Vector) -> Wide:
        """Doubles as they are."""
        return Wide(np.asarray(values, dtype=float), np.zeros_like(values, dtype=float))

    @property
    def T(self) -> Wide:
        """The transpose."""
        return Wide(self.high.T, self.low.T)

    def swapaxes(self, first: int, second: int) -> Wide:
        """Two axes exchanged, as an array does it."""
        return Wide(self.high.swapaxes(first, second), self.low.swapaxes(first, second))

    def __getitem__(self, key: object) -> Wide:
        return Wide(self.high[key], self.low[key])  # type: ignore[call-overload]

    def __neg__(self) -> Wide:
        return Wide(-self.high, -self.low)

    def __add__(self, other: Wide) -> Wide:
        high, low = _two_sum(self.high, other.high)
        rest, least = _two_sum(self.low, other.low)
        high, low = _renormalised(high, low + rest)
        return Wide(*_renormalised(high, low + least))

    def __sub__(self, other: Wide) -> Wide:
        return self + -other

    def __abs__(self) -> Vector:
        """The sizes, to double precision."""
        return np.abs(self.high)

    def __mul__(self, other: Wide | float) -> Wide:
        if not isinstance(other, Wide):
            other = Wide.of(np.full_like(self.high, other))
        high, low = _two_product(self.high, other.high)
        return Wide(*_renormalised(high, low + (self.high * other.low + self.low * other.high)))

    def __truediv__(self, other: Wide) -> Wide:
        first = self.high / other.high
        left = self - Wide.of(first) * other
        second = left.high / other.high
        left = left - Wide.of(second) * other
        high, low = _renormalised(first, second)
        return Wide(*_renormalised(high, low + left.high / other.high))

    def __matmul__(self, other: Wide) -> Wide:
        """The product of two matrices: all products at once, summed by halves."""
        terms = self[:, :, None] * other[None, :, :]
        while terms.high.shape[1] > 1:
            half = terms.high.shape[1] // 2
            summed = terms[:, :half] + terms[:, half : 2 * half]
            left = terms[:, 2 * half :]
            terms = Wide(np.hstack([summed.high, left.high]), np.hstack([summed.low, left.low]))
        return terms[:, 0]


def inverse(matrix: Wide) -> Wide:
    """The inverse of a square matrix, by Gauss and Jordan's elimination with row pivots."""
    size = len(matrix.high)
    high, low = (np.hstack([part, more]) for part, more in ((matrix.high, np.eye(size)), (matrix.low, np.zeros((size, size)))))
    for column in range(size):
        pivot = column + int(np.argmax(np.abs(high[column:, column])))
        for part in (high, low):
            part[[column, pivot]] = part[[pivot, column]]
        rows = Wide(high, low)
        row = rows[column] / rows[column, column, None]
        swept = rows - rows[:, column, None] * row[None, :]
        high, low = swept.high.copy(), swept.low.copy()
        high[column], low[column] = row.high, row.low
    return Wide(high[:, size:], low[:, size:])


def stacked(above: Wide, below: Wide) -> Wide:
    """One matrix above another."""
    return Wide(np.vstack([above.high, below.high]), np.vstack([above.low, below.low]))


def cholesky(matrix: Wide) -> Wide:
    """L with L L^T = matrix, lower triangular.

    Raises:
        LinAlgError: The matrix is not positive definite.
    """
    size = len(matrix.high)
    high, low = np.zeros((2, size, size))
    rest = matrix
    for k in range(size):
        pivot = rest[k, k]
        if not pivot.high > 0:
            raise np.linalg.LinAlgError("the matrix is not positive definite")
        root = np.sqrt(pivot.high)
        # One Newton step doubles the digits of a square root.
        error = pivot - Wide.of(root) * Wide.of(root)
        column = rest[:, k] / (Wide.of(root) + Wide.of(error.high / (2 * root)))[None]
        high[k:, k], low[k:, k] = column.high[k:], column.low[k:]
        rest = rest - column[:, None] * column[None, :]
    return Wide(high, low)


def _two_sum(a: Vector, b: Vector) -> tuple[Vector, Vector]:
    total = a + b
    shift = total - a
    return total, (a - (total - shift)) + (b - shift)


def _renormalised(high: Vector, low: Vector) -> tuple[Vector, Vector]:
    total = high + low
    return total, low - (total - high)


def _two_product(a: Vector, b: Vector) -> tuple[Vector, Vector]:
    product = a * b
    (a_high, a_low), (b_high, b_low) = _split(a), _split(b)
    return product, ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low


def _split(a: Vector) -> tuple[Vector, Vector]:
    scaled = _SPLITTER * a
    high = scaled - (scaled - a)
    return high, a - high
