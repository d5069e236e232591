"""Paper B's Fig. 2 in as many digits as asked for: Taylor series of its planar motion in fixed-point integers.

The motion is chaotic: double precision tells where the cart is for two to four seconds, this for as long as asked. It
shares nothing with phichain but the data of (23).

Examples::

    python -m benchmarks.papers.paper_b_digits              # 4 s with 40 and with 57 digits
    python -m benchmarks.papers.paper_b_digits 10 45 57     # 10 s, some minutes
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from operator import mul

import mpmath

LINKS = range(5)
BEYOND = [5 - k for k in LINKS]
"""Masses from link k on, in units of one; the cart weighs five."""
INERTIA = [[min(BEYOND[k], BEYOND[j]) for j in LINKS] for k in LINKS]
LEVEL = [[10 * INERTIA[k][j] - BEYOND[k] * BEYOND[j] for j in LINKS] for k in LINKS]
"""Ten times the inertia against horizontal motion: the cart gives way by 10 x'' = -sum n_k s_k''."""
GUARD = 20


@dataclass(frozen=True)
class Piece:
    """One step: its start and length, s, coefficients of e_1 . x in (t - start)/step, m, and e_1 . x at its end."""

    start: float
    step: float
    cart: tuple[float, ...]
    last: mpmath.mpf

    def at(self, t: float) -> float:
        """e_1 . x at a time within the step, m."""
        value = 0.0
        for term in reversed(self.cart):
            value = value * (t - self.start) / self.step + term
        return value


def pieces(seconds: float, digits: int) -> Iterator[Piece]:
    """The motion from (23), step by step, with some digits behind the point (`GUARD` more are carried).

    Lengths count in links, 0.1 m. With q_k = (s_k, c_k) in the e_1-e_3 plane, 10 x'' + sum n_k s_k'' = 0, and q_k is
    parallel to sum_j n_max(k,j) q_j'' + n_k x'' e_1 - n_k (g/l) e_3. Order by order the accelerations of the links meet
    the same matrix. Time counts in steps, which keeps the coefficients in range.
    """
    with mpmath.workdps(digits + GUARD + 10):
        one, order = 10 ** (digits + GUARD), round(1.1 * (digits + GUARD))
        lean, stop = mpmath.radians(1), int(Fraction(seconds) * one)
        s, c = [0, 0, 0, 0, int(mpmath.sin(lean) * one)], [-one, one, -one, one, -int(mpmath.cos(lean) * one)]
        w, x, v, time, h = [0] * 5, 2 * one, 0, 0, one // 100
        while time < stop:
            h = min(h, stop - time)
            pull = 981 * h**2 // (10 * one)
            jets, rates, cart = _series([*s, *c], [w_k * h // one for w_k in w], [x, v * h // one], pull, order, one)
            # Root test: from the last coefficients, the share of the step within which the series holds all digits.
            tail = max(max(abs(rate[-1]), abs(rate[-2])) for rate in rates) or 1
            share = min(one, int(one * mpmath.mpf(2 * tail / one) ** (mpmath.mpf(-1) / order) * mpmath.exp(-2)))
            new, part = [_at(jet, share, one) for jet in jets], h * share // one
            s, c, w = new[:5], new[5:], [_at(rate, share, one) * one // h for rate in rates]
            x, v = _at(cart, share, one), _at([n * a for n, a in enumerate(cart)][1:], share, one) * one // h
            scaled = tuple(float(a * mpmath.mpf(share / one) ** n / one / 10) for n, a in enumerate(cart))
            yield Piece(time / one, part / one, scaled, mpmath.mpf(x) / one / 10)
            time, h = time + part, 2 * part


def _series(start: list[int], rate: list[int], cart: list[int], pull: int, order: int, one: int) -> tuple:
    """Coefficients of s and c, of the rates and of the cart up to an order; `pull` is g/l in steps."""
    s, c, w = [[a] for a in start[:5]], [[a] for a in start[5:]], [[a] for a in rate]
    s0, c0 = start[:5], start[5:]
    rows = [[LEVEL[k][j] * c0[k] * c0[j] + 10 * INERTIA[k][j] * s0[k] * s0[j] for j in LINKS] for k in LINKS]
    inverse = [[int(value * 10 * one**3) for value in row] for row in (mpmath.matrix(rows) ** -1).tolist()]
    across: list[list[int]] = [[] for _ in LINKS]
    along: list[list[int]] = [[] for _ in LINKS]
    for n in range(order):
        turned = [(_product(c[k], w[k], one) // (n + 1), -_product(s[k], w[k], one) // (n + 1)) for k in LINKS]
        for k, (across_k, along_k) in enumerate(turned):
            s[k].append(across_k)
            c[k].append(along_k)
        # s'' and c'' but for the share of the unknown W_k = (n + 1) w_(n+1), which is c_k W_k and -s_k W_k.
        s2 = [(n + 1) * _product(c[k][1:], w[k], one) for k in LINKS]
        c2 = [-(n + 1) * _product(s[k][1:], w[k], one) for k in LINKS]
        weight = 0 if n else pull
        right = [
            _product(s[k][1 : n + 1], along[k], one) - _product(c[k][1 : n + 1], across[k], one)
            + s0[k] * (_dot(INERTIA[k], c2) - BEYOND[k] * weight) // one - c0[k] * _dot(LEVEL[k], s2) // (10 * one)
            for k in LINKS
        ]  # fmt: skip
        W = [_dot(row, right) // one for row in inverse]
        s2 = [known + c0[k] * W[k] // one for k, known in enumerate(s2)]
        c2 = [known - s0[k] * W[k] // one for k, known in enumerate(c2)]
        for k in LINKS:
            across[k].append(_dot(LEVEL[k], s2) // 10)
            along[k].append(_dot(INERTIA[k], c2) - BEYOND[k] * weight)
            w[k].append(W[k] // (n + 1))
        cart.append(-_dot(BEYOND, s2) // (10 * (n + 1) * (n + 2)))
    return [*s, *c], w, cart


def _dot(a: Sequence[int], b: Sequence[int]) -> int:
    return sum(map(mul, a, b))


def _product(a: Sequence[int], b: Sequence[int], one: int) -> int:
    """The last coefficient of the product of two series of equal length."""
    return sum(map(mul, a, reversed(b))) // one


def _at(series: Sequence[int], share: int, one: int) -> int:
    value = 0
    for term in reversed(series):
        value = value * share // one + term
    return value


def main(seconds: float = 4.0, digits: Sequence[int] = (40, 57)) -> None:
    for carried in digits:
        run = list(pieces(seconds, carried))
        cart = [piece.at(piece.start + piece.step * k / 50) for piece in run for k in range(51)]
        end = mpmath.nstr(run[-1].last, 25)
        print(f"{carried} digits: e_1 . x in {min(cart):.6f} .. {max(cart):.6f} m, {end} m at {seconds:g} s")


if __name__ == "__main__":
    main(*(float(word) for word in sys.argv[1:2]), *([[int(word) for word in sys.argv[2:]]] if sys.argv[2:] else []))
