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
from fractions import Fraction
from functools import lru_cache
from math import ceil, comb, factorial

import numpy as np
from numpy.typing import NDArray
from scipy.special import rgamma

Vector = NDArray[np.float64]

# From these n on the expansion in 1/n has relative error below 5e-15: the roots of delta_p other than 1 contribute
# |root|^-n, with 1/|root| = 0.33, 0.43, 0.56, 0.71, 0.86 for p = 2..6.
HEAD = {1: 32, 2: 64, 3: 80, 4: 96, 5: 160, 6: 320}
ORDERS = tuple(HEAD)
# Terms of the expansion, and the few that are left of it beyond n = FAR.
TERMS = 20
FAR, FAR_TERMS = 2048, 8


@dataclass(frozen=True)
class Quadrature:
    """The weights of one order p for several alpha with the same number m of starting values.

    Attributes:
        order: p, 1 to 6.
        starting: m, the quadrature with its correction is exact on polynomials of degree < m.
        alpha: The orders of differintegration, shape (A,).
        head: w_n for n < H, shape (A, H).
        series: d_k / Gamma(-alpha-k), shape (A, TERMS).
        defects: -b_qk / Gamma(-alpha-k) from k = -lift on, shape (A, m, lift + TERMS).
        lift: How many powers of n the error on t^(m-1) lies above n^(-alpha-1).
    """

    order: int
    starting: int
    alpha: Vector
    head: Vector
    series: Vector
    defects: Vector
    lift: int


def starting_values(order: int, alpha: float) -> int:
    """m = p + max(0, ceil(alpha)): exactness on t^q for q < m leaves an error of order h^(m-alpha) at every t."""
    return order + max(0, ceil(alpha))


def quadrature(order: int, starting: int, alpha: Vector) -> Quadrature:
    """Prepare the weights of order p at the given alpha.

    Args:
        order: p, 1 to 6.
        starting: m, at least p.
        alpha: Orders of differintegration, shape (A,).
    """
    lift = starting - order
    powers = _power_series(_laurent(order), alpha, TERMS + starting)
    gammas = _reciprocal_gammas(alpha, -lift, lift + TERMS)
    defects = np.stack([-gammas * _defect(powers, order, q, lift) for q in range(starting)], axis=1)
    return Quadrature(
        order, starting, alpha, _head(order, alpha), powers[:, :TERMS] * gammas[:, lift:], defects, lift
    )


def weights(rule: Quadrature, rows: slice, basis: Basis) -> Vector:
    """w_0 .. w_(n-1) of those rows of alpha, shape (rows, n)."""
    alpha, head = rule.alpha[rows], rule.head[rows, : basis.size]
    result = np.empty((alpha.size, basis.size))
    result[:, : head.shape[1]] = head
    if basis.far_from < basis.size:
        result[:, basis.far_from :] = basis.power(-alpha - 1.0) * basis.polynomial(rule.series[rows])
    return result


def correction(rule: Quadrature, rows: slice, basis: Basis, polynomial: Vector) -> Vector:
    """Starting correction sum_q E_q(n) c_q of a signal whose first m samples lie on sum_q c_q n^q.

    Args:
        rule: The quadrature.
        rows: Which of its alpha.
        basis: The powers of n.
        polynomial: c_q in units of the step, shape (m,).

    Returns:
        What to add to sum_j w_(n-j) f_j, shape (rows, n).
    """
    alpha = rule.alpha[rows]
    result = np.empty((alpha.size, basis.size))
    near = min(basis.far_from, basis.size)
    result[:, :near] = _near_correction(rule, rows, near, polynomial)
    if near < basis.size:
        coefficients = np.einsum("amk,m->ak", rule.defects[rows], polynomial)
        result[:, near:] = basis.power(rule.lift - alpha - 1.0) * basis.polynomial(coefficients)
    return result


def _near_correction(rule: Quadrature, rows: slice, near: int, polynomial: Vector) -> Vector:
    # For n < H the difference "exact minus quadrature" loses eps n^(q-alpha) at most, which the size of c_q, h^q, undoes.
    alpha = rule.alpha[rows]
    n = np.arange(near, dtype=float)
    samples = np.polynomial.polynomial.polyval(n, polynomial)
    toeplitz = np.triu(samples[np.abs(n[None, :] - n[:, None]).astype(int)])
    return polynomial_differintegral(alpha, n, polynomial) - rule.head[rows, :near] @ toeplitz


def polynomial_differintegral(alpha: Vector, t: Vector, polynomial: Vector) -> Vector:
    """D^alpha sum_q c_q t^q = sum_q c_q Gamma(q+1) / Gamma(q+1-alpha) t^(q-alpha), shape (A, n); inf becomes NaN."""
    result = np.zeros((alpha.size, t.size))
    for q, coefficient in enumerate(polynomial):
        factor = coefficient * factorial(q) * rgamma(q + 1.0 - alpha)
        with np.errstate(divide="ignore", invalid="ignore"):
            term = factor[:, None] * t ** (q - alpha[:, None])
            term[factor == 0.0] = 0.0
            result += term
    result[~np.isfinite(result)] = np.nan
    return result


def starting_polynomial(samples: Vector) -> Vector:
    """Coefficients c_q of the polynomial through (n, f_n), n = 0 .. m-1, in units of the step; shape (m, ...)."""
    result: Vector = _inverse_vandermonde(samples.shape[0]) @ samples
    return result


class Basis:
    """Powers of n from the head's end on, shared by every alpha of one call.

    Attributes:
        size: Number of samples n.
        far_from: H, where the expansion takes over.
    """

    def __init__(self, order: int, size: int) -> None:
        self.size = size
        self.far_from = HEAD[order]
        n = np.arange(self.far_from, max(size, self.far_from), dtype=float)
        self._log = np.log(n)
        split = max(0, FAR - self.far_from)
        self._near = (1.0 / n[:split]) ** np.arange(TERMS + 8)[:, None]
        self._far = (1.0 / n[split:]) ** np.arange(FAR_TERMS + 8)[:, None]

    def power(self, exponent: Vector) -> Vector:
        """n^exponent, shape (A, n - H)."""
        result: Vector = exponent[:, None] * self._log
        return np.exp(result, out=result)

    def polynomial(self, coefficients: Vector) -> Vector:
        """sum_k coefficients_k n^-k, shape (A, n - H)."""
        terms = coefficients.shape[1]
        far_terms = terms - (TERMS - FAR_TERMS)
        near = coefficients @ self._near[:terms]
        far = coefficients[:, :far_terms] @ self._far[:far_terms]
        return np.concatenate([near, far], axis=1)


def _head(order: int, alpha: Vector) -> Vector:
    size = HEAD[order]
    steps = np.arange(1, size)
    gruenwald = np.cumprod(np.concatenate([np.ones((alpha.size, 1)), 1.0 - (alpha[:, None] + 1.0) / steps], axis=1), axis=1)
    smooth = _power_series(_smooth_factor(order), alpha, size)
    head = np.stack([np.convolve(g, s)[:size] for g, s in zip(gruenwald, smooth, strict=True)])
    finite = (alpha >= 0) & (alpha == np.round(alpha))
    for row in np.flatnonzero(finite):
        head[row, order * int(alpha[row]) + 1 :] = 0.0
    return head


def _power_series(base: Vector, alpha: Vector, terms: int) -> Vector:
    """Coefficients of (sum_k base_k z^k)^alpha by J. C. P. Miller's recurrence, shape (A, terms)."""
    result = np.zeros((alpha.size, terms))
    result[:, 0] = base[0] ** alpha
    for k in range(1, terms):
        j = np.arange(1, min(base.size - 1, k) + 1)
        factor = (alpha[:, None] * j - (k - j)) * base[j]
        result[:, k] = np.sum(factor * result[:, k - j], axis=1) / (k * base[0])
    return result


def _reciprocal_gammas(alpha: Vector, first: int, terms: int) -> Vector:
    """1 / Gamma(-alpha-k) from k = first on, by 1/Gamma(x-1) = (x-1)/Gamma(x): its zeros come out exact; (A, terms)."""
    steps = -alpha[:, None] - np.arange(first + 1, first + terms)
    return np.cumprod(np.concatenate([rgamma(-alpha - first)[:, None], steps], axis=1), axis=1)


def _defect(powers: Vector, order: int, q: int, lift: int) -> Vector:
    """b_qk for k = -lift .. TERMS-1, shape (A, lift + TERMS)."""
    sums = _power_sum_series(q)
    result = np.zeros((powers.shape[0], lift + TERMS))
    result[:, lift:] = [np.convolve(row[:TERMS], sums)[:TERMS] for row in powers]
    for k in range(max(-lift, order - q - 1), TERMS):
        result[:, k + lift] += factorial(q) * powers[:, k + q + 1]
    return result


@lru_cache
def _smooth_factor(order: int) -> Vector:
    """delta_p(z) / (1 - z) = sum_(l=1..p) (1 - z)^(l-1) / l in powers of z."""
    total = [Fraction(0)] * order
    for degree in range(order):
        for j in range(degree + 1):
            total[j] += Fraction((-1) ** j * comb(degree, j), degree + 1)
    return np.array([float(c) for c in total])


@lru_cache
def _laurent(order: int) -> Vector:
    """delta_p(e^-s) / s in powers of s: 1 + O(s^p), from exact rationals."""
    terms = TERMS + 12
    base = [Fraction(0)] + [Fraction((-1) ** (k + 1), factorial(k)) for k in range(1, terms + 1)]
    power, total = [Fraction(1)] + [Fraction(0)] * terms, [Fraction(0)] * (terms + 1)
    for degree in range(1, order + 1):
        power = [sum((power[i] * base[k - i] for i in range(k + 1)), Fraction(0)) for k in range(terms + 1)]
        total = [a + b / degree for a, b in zip(total, power, strict=True)]
    return np.array([float(c) for c in total[1:]])


@lru_cache
def _power_sum_series(q: int) -> Vector:
    """Regular part of sum_(j>=0) j^q e^(-sj) in powers of s, with 0^0 = 1: zeta(-q-k) (-1)^k / k!."""
    numbers = _bernoulli(q + TERMS)
    exact = [-numbers[q + k + 1] / ((q + k + 1) * factorial(k)) * (-1) ** k for k in range(TERMS)]
    series = np.array([float(c) for c in exact])
    if q == 0:
        series[0] += 1.0
    return series


@lru_cache
def _bernoulli(last: int) -> list[Fraction]:
    """B_0 .. B_last with B_1 = +1/2, so that zeta(-n) = -B_(n+1)/(n+1) for every n >= 0."""
    numbers: list[Fraction] = []
    for n in range(last + 1):
        numbers.append(1 - sum((comb(n, k) * b / (n - k + 1) for k, b in enumerate(numbers)), Fraction(0)))
    return numbers


@lru_cache
def difference_weights(width: int, degree: int, node: int) -> Vector:
    """Weights of the derivative of that degree at one of the nodes 0 .. width-1, unit step, exact on their polynomial."""
    weights = []
    for polynomial in _lagrange(width):
        for _ in range(degree):
            polynomial = [k * c for k, c in enumerate(polynomial)][1:]
        weights.append(float(sum((c * node**k for k, c in enumerate(polynomial)), Fraction(0))))
    return np.array(weights)


@lru_cache
def _inverse_vandermonde(size: int) -> Vector:
    return np.array([[float(c) for c in polynomial] for polynomial in _lagrange(size)]).T


@lru_cache
def _lagrange(size: int) -> list[list[Fraction]]:
    """Coefficients of the Lagrange polynomials of the nodes 0 .. size-1, exact."""
    polynomials = []
    for node in range(size):
        polynomial = [Fraction(1)]
        for other in (k for k in range(size) if k != node):
            raised, kept = [Fraction(0), *polynomial], [*polynomial, Fraction(0)]
            polynomial = [(a - other * b) / (node - other) for a, b in zip(raised, kept, strict=True)]
        polynomials.append(polynomial)
    return polynomials
