"""The loop around one place of a spatial chain that rubs, in any arithmetic: what `stencils/flow/sums.c` does in C.

T(s) about s_0 is sum f_k (s - s_0)^k. With q = 1 - s T^2, of which q' = -T q, and 2 s T' = q - T,

    (k + 1) q_{k+1} = -sum_j f_j q_{k-j},    2 s_0 (k + 1) f_{k+1} = q_k - (2 k + 1) f_k

holds exactly wherever s_0 is not zero; in doubles it serves for s_0 >= 4, and below the continued fraction
T = 1 / (1 + s / (3 + s / (5 + ...))) takes its place.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from fractions import Fraction
from functools import cached_property
from typing import Any

from phichain.lowering.series.series import RUB_LANES, Series

Scalar = Any
Row = list[Scalar]


def rub_lane(series: Series, i: int) -> int:
    """Where a left row has the numbers of a place."""
    return series.lanes + RUB_LANES * i


class Rubbed:
    """One place over the orders of a step."""

    def __init__(
        self, total: Callable[[Iterable[tuple[Scalar, Scalar]]], Scalar], number: Callable[[Fraction], Scalar],
        inverse: Callable[[Scalar], Scalar], start: Row, orders: int,
    ) -> None:  # fmt: skip
        """Prepare.

        Args:
            total: sums of products.
            number: exact numbers.
            inverse: 1 / x.
            start: w_0, the steepness and T_0.
            orders: how many orders there will be.
        """
        self._total, self._number, self._inverse, self._start, self._orders = total, number, inverse, start, orders
        self._powers: list[dict[int, Scalar]] = []

    @cached_property
    def slopes(self) -> Row:
        """f_k, k = 0 .. orders + 1."""
        total, number, one = self._total, self._number, self._number(Fraction(1))
        *_, steepness, share = self._start
        # s T^2 = tanh^2 = 1 - q says what s is in the field, too, where half of all elements have no root.
        lost = self._inverse(total([(one, number(Fraction(2))), (steepness, number(Fraction(-2)))]))
        over, f, q = total([(total([(share, share)]), lost)]), [share], [steepness]
        for k in range(self._orders + 1):
            rest = total([(q[k], one), (f[k], number(Fraction(-2 * k - 1)))])
            step = number(Fraction(1, k + 1))
            f.append(total([(total([(rest, over)]), step)]))
            q.append(total([(total([(f[j], q[k - j]) for j in range(k + 1)]), number(Fraction(-1, k + 1)))]))
        return f

    def sums(self, rows: Sequence[Row], n: int) -> Row:
        """Sums of order n from the left rows up to n."""
        zero = self._number(Fraction(0))
        if n == 0:
            return [zero] * 5 + [self.slopes[1]]
        inner = range(1, n)
        squares = self._total([(rows[j + 1][a], rows[n - j + 1][a]) for j in inner for a in range(3)])
        turned = [self._total([(rows[j + 1][4], rows[n - j + 1][a]) for j in inner]) for a in range(3)]
        self._raise(rows, n)
        beyond = self._total([(self.slopes[k], self._power(rows, k, n)) for k in range(2, n + 1)])
        return [squares, *turned, beyond, self.slopes[1]]

    def moved_sums(self, rows: Sequence[Row], moved: Sequence[Row], n: int) -> Row:
        """Their derivatives of order n but that of f_1, which is in the rest; from all left rows and those of the derivatives up to n."""
        two = self._number(Fraction(2))
        squares = self._total([(rows[j + 1][a], moved[n - j + 1][a]) for j in range(1, n + 1) for a in range(3)])
        turned = [
            self._total([(rows[j + 1][4], moved[n - j + 1][a]) for j in range(1, n + 1)] + [(moved[j + 1][4], rows[n - j + 1][a]) for j in range(n)])
            for a in range(3)
        ]
        beyond = self._total([(self._bend(rows, n - j), moved[j + 1][3]) for j in range(n)])
        return [self._total([(squares, two)]), *turned, beyond]

    def _bend(self, rows: Sequence[Row], n: int) -> Scalar:
        """The coefficient of T'(s), n > 0."""
        terms = [(self._total([(self.slopes[k + 1], self._number(Fraction(k + 1)))]), self._power(rows, k, n)) for k in range(1, n + 1)]
        return self._total(terms)

    def _power(self, rows: Sequence[Row], k: int, n: int) -> Scalar:
        """The coefficient n of (s - s_0)^k, n >= k."""
        return rows[n + 1][3] if k == 1 else self._powers[n][k]

    def _raise(self, rows: Sequence[Row], n: int) -> None:
        """Powers of order n from s_1 .. s_{n-1}."""
        self._powers = self._powers[:n]
        while len(self._powers) <= n:
            at = len(self._powers)
            made = {k: self._total([(rows[j + 1][3], self._power(rows, k - 1, at - j)) for j in range(1, at - k + 2)]) for k in range(2, at + 1)}
            self._powers.append(made)
