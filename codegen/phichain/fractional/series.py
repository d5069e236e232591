"""Exact numbers and power series behind the quadrature weights: everything that depends on the order p alone.

The rational arithmetic here runs once per order and is remembered.
"""

from __future__ import annotations

from fractions import Fraction
from functools import lru_cache
from math import comb, factorial

import numpy as np
from numpy.typing import NDArray
from scipy.special import rgamma

Vector = NDArray[np.float64]


def power_series(base: Vector, alpha: Vector, terms: int) -> Vector:
    """Coefficients of (sum_k base_k z^k)^alpha by J. C. P. Miller's recurrence, shape (terms, A).

    k base_0 r_k = (alpha + 1) sum_j j base_j r_(k-j) - k sum_j base_j r_(k-j),  j = 1 .. degree.
    """
    degree = base.size - 1
    padded = np.zeros((degree + terms, alpha.size))
    padded[degree] = base[0] ** alpha
    ratios = base[:0:-1] / base[0]
    pair = np.stack([ratios * np.arange(degree, 0, -1), ratios])
    for k in range(1, terms):
        weighted, plain = pair @ padded[k : k + degree]
        padded[degree + k] = (alpha + 1.0) * weighted / k - plain
    return padded[degree:]


def reciprocal_gammas(alpha: Vector, first: int, terms: int) -> Vector:
    """1 / Gamma(-alpha-k) from k = first on, by 1/Gamma(x-1) = (x-1)/Gamma(x): its zeros come out exact; (terms, A)."""
    steps = -alpha - np.arange(first + 1, first + terms)[:, None]
    return np.cumprod(np.concatenate([rgamma(-alpha - first)[None, :], steps]), axis=0)


@lru_cache
def smooth_factor(order: int) -> Vector:
    """delta_p(z) / (1 - z) = sum_(l=1..p) (1 - z)^(l-1) / l in powers of z."""
    total = [Fraction(0)] * order
    for degree in range(order):
        for j in range(degree + 1):
            total[j] += Fraction((-1) ** j * comb(degree, j), degree + 1)
    return np.array([float(c) for c in total])


@lru_cache
def symbol_series(order: int, terms: int) -> Vector:
    """delta_p(e^-s) / s in powers of s: 1 + O(s^p)."""
    base = [Fraction(0)] + [Fraction((-1) ** (k + 1), factorial(k)) for k in range(1, terms + 1)]
    power, total = [Fraction(1)] + [Fraction(0)] * terms, [Fraction(0)] * (terms + 1)
    for degree in range(1, order + 1):
        power = [sum((power[i] * base[k - i] for i in range(k + 1)), Fraction(0)) for k in range(terms + 1)]
        total = [a + b / degree for a, b in zip(total, power, strict=True)]
    return np.array([float(c) for c in total[1:]])


@lru_cache
def power_sum_series(q: int, terms: int) -> Vector:
    """Regular part of sum_(j>=0) j^q e^(-sj) in powers of s, with 0^0 = 1: zeta(-q-k) (-1)^k / k!."""
    numbers = _bernoulli(q + terms)
    exact = [-numbers[q + k + 1] / ((q + k + 1) * factorial(k)) * (-1) ** k for k in range(terms)]
    series = np.array([float(c) for c in exact])
    if q == 0:
        series[0] += 1.0
    return series


@lru_cache
def difference_weights(width: int, degree: int, node: int) -> Vector:
    """Weights of the derivative of that degree at one of the nodes 0 .. width-1, unit step, exact on polynomials."""
    weights = []
    for polynomial in _lagrange(width):
        for _ in range(degree):
            polynomial = [k * c for k, c in enumerate(polynomial)][1:]
        weights.append(float(sum((c * node**k for k, c in enumerate(polynomial)), Fraction(0))))
    return np.array(weights)


@lru_cache
def inverse_vandermonde(size: int) -> Vector:
    """Inverse of the matrix n^q, n, q = 0 .. size-1: samples to polynomial coefficients."""
    return np.array([[float(c) for c in polynomial] for polynomial in _lagrange(size)]).T


@lru_cache
def _lagrange(size: int) -> list[list[Fraction]]:
    """Coefficients of the Lagrange polynomials of the nodes 0 .. size-1."""
    polynomials = []
    for node in range(size):
        polynomial = [Fraction(1)]
        for other in (k for k in range(size) if k != node):
            raised, kept = [Fraction(0), *polynomial], [*polynomial, Fraction(0)]
            polynomial = [(a - other * b) / (node - other) for a, b in zip(raised, kept, strict=True)]
        polynomials.append(polynomial)
    return polynomials


@lru_cache
def _bernoulli(last: int) -> list[Fraction]:
    """B_0 .. B_last with B_1 = +1/2, so that zeta(-n) = -B_(n+1)/(n+1) for every n >= 0."""
    numbers: list[Fraction] = []
    for n in range(last + 1):
        known = (comb(n, k) * b / (n - k + 1) for k, b in enumerate(numbers))
        numbers.append(1 - sum(known, Fraction(0)))
    return numbers
