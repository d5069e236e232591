"""Differintegrals known in closed form, and quadrature weights at 40 digits: oracles blind to the package."""

from __future__ import annotations

from fractions import Fraction
from math import comb

import mpmath
import numpy as np
from scipy.special import gamma, rgamma


def power(alpha: float, exponent: float, t: np.ndarray) -> np.ndarray:
    """D^alpha t^b = Gamma(b+1) / Gamma(b+1-alpha) t^(b-alpha)."""
    return gamma(exponent + 1.0) * rgamma(exponent + 1.0 - alpha) * t ** (exponent - alpha)


def cosine(alpha: float, omega: float, phase: float, t: np.ndarray) -> np.ndarray:
    """D^alpha cos(omega t + phase) = Re e^(i phase) t^-alpha sum_k (i omega t)^k / Gamma(k+1-alpha), for omega t < 5."""
    k = np.arange(60)
    terms = (1j * omega * t[:, None]) ** k * rgamma(k + 1.0 - alpha)
    return np.real(np.exp(1j * phase) * terms.sum(axis=1)) * t**-alpha


def exponential(alpha: float, rate: float, t: float) -> float:
    """D^alpha e^(rate t) = t^-alpha E_(1,1-alpha)(rate t), the Mittag-Leffler function, at 30 digits."""
    with mpmath.workdps(30):
        series = mpmath.nsum(
            lambda k: (mpmath.mpf(rate) * t) ** int(k) * mpmath.rgamma(k + 1 - mpmath.mpf(alpha)),
            [0, mpmath.inf],
        )
        return float(series * mpmath.mpf(t) ** -mpmath.mpf(alpha))


def lubich_weights(order: int, alpha: float, count: int) -> list[mpmath.mpf]:
    """w_0 .. of delta_p(z)^alpha by Miller's recurrence on the BDF polynomial itself; call within mpmath.workdps."""
    polynomial = [Fraction(0)] * (order + 1)
    for degree in range(1, order + 1):
        for j in range(degree + 1):
            polynomial[j] += Fraction((-1) ** j * comb(degree, j), degree)
    base = [mpmath.mpf(c.numerator) / c.denominator for c in polynomial]
    a = mpmath.mpf(alpha)
    weights = [base[0] ** a]
    for k in range(1, count):
        terms = ((a * j - (k - j)) * base[j] * weights[k - j] for j in range(1, min(order, k) + 1))
        weights.append(mpmath.fsum(terms) / (k * base[0]))
    return weights


def naive_grunwald_letnikov(signal: np.ndarray, step: float, alpha: float) -> np.ndarray:
    """Equations (2)-(3) as a double loop."""
    result = []
    for n in range(len(signal)):
        weight, total = 1.0, 0.0
        for k in range(n + 1):
            total += weight * signal[n - k]
            weight *= (k - alpha) / (k + 1)
        result.append(total * step**-alpha)
    return np.array(result)
