"""Weights of convolution quadrature and the error it makes on powers of t, in closed form and without recursion.

Lubich's quadrature of the differintegral of order alpha on the grid t_n = n h is

    D^alpha f(t_n) = h^-alpha [ sum_(j=0..n) w_(n-j) f_j + starting correction ],   sum_n w_n z^n = delta_p(z)^alpha,
    delta_p(z) = sum_(l=1..p) (1 - z)^l / l,

with the generating polynomial delta_p of the BDF method of order p (p = 1: the Gruenwald-Letnikov weights of
equations (2)-(3)). Two facts make the weights cheap and accurate to round-off:

* Head, n < H: delta_p^alpha = (1 - z)^alpha g(z), where g decays geometrically.
* Tail, n >= H: only the singularity at z = 1 is felt. With z = e^-s, delta_p(e^-s)^alpha = s^alpha sum_k d_k s^k, and
  the coefficient of z^n in s^beta is n^(-beta-1) / Gamma(-beta):

      w_n = n^(-alpha-1) sum_k d_k / Gamma(-alpha-k) n^-k.

The starting correction makes the quadrature exact on polynomials of degree < m. It needs the quadrature's error on
t^q; computed as the difference exact minus quadrature it would cancel from n^(q-alpha) down to n^(-alpha-1), up to 30
digits. The same expansion gives it outright: sum_j j^q e^(-sj) = q!/s^(q+1) + sum_k zeta(-q-k) (-s)^k / k!, so

    E_q(n) = exact - quadrature = - sum_k b_qk / Gamma(-alpha-k) n^(-alpha-1-k),
    sum_k b_qk s^k = (sum_i d_i s^i)(sum_j j^q e^(-sj)) - q!/s^(q+1).

Sources: Ch. Lubich, Discretized fractional calculus, SIAM J. Math. Anal. 17 (1986) 704-719; on the cancellation,
K. Diethelm, J. M. Ford, N. J. Ford, M. Weilbeer, J. Comput. Appl. Math. 186 (2006) 482-503.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from math import ceil, factorial

import numpy as np
from numpy.typing import NDArray
from scipy.special import rgamma

from phichain.fractional.series import (
    inverse_vandermonde,
    power_series,
    power_sum_series,
    reciprocal_gammas,
    smooth_factor,
    symbol_series,
)
from phichain.fractional.threads import product
from phichain.records import Held

Vector = NDArray[np.float64]

# From these n on the expansion in 1/n has relative error below 5e-15: the roots of delta_p other than 1 contribute
# |root|^-n, with 1/|root| = 0.33, 0.43, 0.56, 0.71, 0.86 for p = 2..6.
HEAD = {1: 32, 2: 64, 3: 80, 4: 96, 5: 160, 6: 320}
ORDERS = tuple(HEAD)
# Coefficients of g that reach 1e-17, for the same reason.
_TAPS = {1: 1, 2: 40, 3: 52, 4: 76, 5: 124, 6: 288}
# Terms of the expansion, and the few that are left of it beyond n = FAR; derivatives lift the first power by up to 3.
TERMS = 20
_FAR, _FAR_TERMS = 2048, 8
# Samples whose powers are made together: they stay in the cache.
_PIECE = 2**14


@dataclass(frozen=True)
class Quadrature(Held):
    """The weights of one order p for several alpha with the same number m of starting values.

    Attributes:
        order: p, 1 to 6.
        starting: m, the quadrature with its correction is exact on polynomials of degree < m.
        alpha: The orders of differintegration, shape (A,).
        head: w_n for n < H, shape (A, H), cut where the signal ends.
        series: d_k / Gamma(-alpha-k), shape (A, TERMS).
        defects: -b_qk / Gamma(-alpha-k) from k = -lift on, shape (m, A, lift + TERMS).
        lift: How many powers of n the error on t^(m-1) lies above n^(-alpha-1).
    """

    order: int
    starting: int
    alpha: Vector
    head: Vector
    series: Vector
    defects: Vector
    lift: int


@dataclass(frozen=True)
class Start(Held):
    """The beginning of one signal, as its starting correction needs it.

    Attributes:
        polynomial: c_q of the polynomial through the first m samples, in units of the step, shape (m,).
        toeplitz: Its values as a triangular Toeplitz matrix, shape (H, H).
        vanishing: How many of the c_q, from the first on, cannot be told from zero.
    """

    polynomial: Vector
    toeplitz: Vector
    vanishing: int


def starting_values(order: int, alpha: float) -> int:
    """m = p + max(0, ceil(alpha)): exactness on t^q for q < m leaves an error of order h^(m-alpha) at every t."""
    return order + max(0, ceil(alpha))


def quadrature(order: int, starting: int, alpha: Vector, size: int) -> Quadrature:
    """Prepare the weights of order p at the given alpha for signals of that size.

    Args:
        order: p, 1 to 6.
        starting: m, at least p.
        alpha: Orders of differintegration, shape (A,).
        size: Number of samples.
    """
    lift = starting - order
    head = _head(order, alpha, min(HEAD[order], size))
    if size <= HEAD[order]:
        nothing = np.empty((alpha.size, 0))
        return Quadrature(order, starting, alpha, head, nothing, nothing[None], lift)
    powers = power_series(symbol_series(order, TERMS + starting + 1), alpha, TERMS + starting)
    gammas = reciprocal_gammas(alpha, -lift, lift + TERMS)
    defects = np.stack([(-gammas * _defect(powers, order, q, lift)).T for q in range(starting)])
    return Quadrature(order, starting, alpha, head, (powers[:TERMS] * gammas[lift:]).T.copy(), defects, lift)


def _defect(powers: Vector, order: int, q: int, lift: int) -> Vector:
    """b_qk for k = -lift .. TERMS-1, shape (lift + TERMS, A)."""
    sums = power_sum_series(q, TERMS)
    lag = np.arange(TERMS)[:, None] - np.arange(TERMS)
    result = np.zeros((lift + TERMS, powers.shape[1]))
    result[lift:] = np.where(lag >= 0, sums[np.abs(lag)], 0.0) @ powers[:TERMS]
    for k in range(max(-lift, order - q - 1), TERMS):
        result[k + lift] += factorial(q) * powers[k + q + 1]
    return result


def _head(order: int, alpha: Vector, size: int) -> Vector:
    steps = np.arange(1, size)[:, None]
    gruenwald = np.cumprod(np.concatenate([np.ones((1, alpha.size)), 1.0 - (alpha + 1.0) / steps]), axis=0)
    smooth = power_series(smooth_factor(order), alpha, min(_TAPS[order], size))
    head = smooth[0] * gruenwald
    for k in range(1, smooth.shape[0]):
        head[k:] += smooth[k] * gruenwald[:-k]
    for column in np.flatnonzero((alpha >= 0) & (alpha == np.round(alpha))):
        head[order * int(alpha[column]) + 1 :, column] = 0.0
    return head.T.copy()


class Basis:
    """The samples from the head's end on, piece by piece, so that no table of powers of n is as long as the signal.

    Attributes:
        size: Number of samples n.
        near: How many of them are the head's.
        pieces: Where each piece behind the head begins and ends.
    """

    def __init__(self, order: int, size: int) -> None:
        self.size = size
        self.near = min(HEAD[order], size)
        bounds = [self.near, *range(_FAR, size, _PIECE), size] if size > _FAR else [self.near, size]
        self.pieces = [slice(*ends) for ends in pairwise(bounds) if ends[0] < ends[1]]

    def tail(self, piece: slice, exponent: Vector, coefficients: Vector) -> Vector:
        """n^exponent sum_k coefficients_k n^-k of one piece, shape (A, length of the piece)."""
        n = np.arange(piece.start, piece.stop, dtype=float)
        terms = coefficients.shape[1] - (TERMS - _FAR_TERMS if piece.start >= _FAR else 0)
        inverse = np.empty((terms, n.size))
        inverse[0] = 1.0
        np.divide(1.0, n, out=inverse[1])
        for k in range(2, terms):
            np.multiply(inverse[k - 1], inverse[1], out=inverse[k])
        result = product(coefficients[:, :terms], inverse)
        power = exponent[:, None] * np.log(n)
        result *= np.exp(power, out=power)
        return result


def weights(rule: Quadrature, rows: slice, basis: Basis) -> Vector:
    """w_0 .. w_(n-1) of those rows of alpha, shape (rows, n)."""
    head = rule.head[rows]
    result = np.empty((head.shape[0], basis.size))
    result[:, : basis.near] = head
    for piece in basis.pieces:
        result[:, piece] = basis.tail(piece, -rule.alpha[rows] - 1.0, rule.series[rows])
    return result


def start(samples: Vector, starting: int, basis: Basis) -> Start:
    """Prepare the starting correction of a signal, shape (n,)."""
    polynomial = starting_polynomial(samples[:starting])
    values = np.polynomial.polynomial.polyval(np.arange(basis.near, dtype=float), polynomial)
    return Start(polynomial, triangular_toeplitz(values), _vanishing(samples, polynomial))


def _vanishing(samples: Vector, polynomial: Vector) -> int:
    """How many derivatives from the 0th on vanish at t = 0: their c_q cannot be told from zero.

    What c_q may be off by is the rounding of the samples and, from q = 1 on, what one sample less makes of it.
    """
    count = polynomial.size
    size = max(float(np.max(samples)), -float(np.min(samples)))
    doubt = 4 * np.finfo(float).eps * size * np.sum(np.abs(inverse_vandermonde(count)), axis=1)
    if count > 1:
        doubt[:-1] += 4 * np.abs(polynomial[:-1] - starting_polynomial(samples[: count - 1]))
    felt = np.flatnonzero(np.abs(polynomial) > doubt)
    return int(felt[0]) if felt.size else count


def correct(out: Vector, rule: Quadrature, rows: slice, basis: Basis, begin: Start) -> None:
    """Add the starting correction sum_q E_q(n) c_q of a signal to sum_j w_(n-j) f_j, shape (rows, n)."""
    alpha, polynomial, near = rule.alpha[rows], begin.polynomial, basis.near
    # In the head the plain difference will do: it loses eps n^(q-alpha), and c_q is of order h^q.
    exact = polynomial_differintegral(alpha, near, polynomial, begin.vanishing)
    out[:, :near] += exact - product(rule.head[rows], begin.toeplitz)
    for piece in basis.pieces:
        coefficients = np.tensordot(polynomial, rule.defects[:, rows], axes=1)
        out[:, piece] += basis.tail(piece, rule.lift - alpha - 1.0, coefficients)


def polynomial_differintegral(alpha: Vector, size: int, polynomial: Vector, vanishing: int = 0) -> Vector:
    """D^alpha sum_q c_q t^q = sum_q c_q Gamma(q+1) / Gamma(q+1-alpha) t^(q-alpha) at t = 0 .. size-1, shape (A, size).

    At t = 0, for alpha > 0 and not an integer, the value is 0 where the first `vanishing` c_q count as zero and
    alpha < vanishing, and NaN elsewhere.
    """
    q = np.arange(polynomial.size)
    factors = polynomial * np.array([float(factorial(k)) for k in q]) * rgamma(q + 1.0 - alpha[:, None])
    t = np.arange(1.0, size)
    result = np.empty((alpha.size, size))
    result[:, 1:] = np.exp(-alpha[:, None] * np.log(t)) * (factors @ t ** q[:, None])
    unbounded = (alpha > vanishing) & (alpha != np.round(alpha))
    result[:, 0] = np.where(unbounded, np.nan, np.sum(factors * (q == alpha[:, None]), axis=1))
    return result


def starting_polynomial(samples: Vector) -> Vector:
    """Coefficients c_q of the polynomial through (n, f_n), n = 0 .. m-1, in units of the step; shape (m,)."""
    return inverse_vandermonde(samples.shape[0]) @ samples


def triangular_toeplitz(row: Vector) -> Vector:
    """The matrix T with (w T)_n = sum_(j<=n) w_j row_(n-j)."""
    lag = np.arange(row.size) - np.arange(row.size)[:, None]
    return np.where(lag >= 0, row[np.abs(lag)], 0.0)
