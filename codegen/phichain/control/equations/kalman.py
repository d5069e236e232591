"""Stationary observers of a sampled chain z_{k+1} = A_d z_k + B_d u_k + w_k that is measured as y_k = C z_k + v_k.

The covariance of what is expected before a measurement solves the discrete Riccati equation of the transposed problem,

    P = A_d (P - P C^T (C P C^T + V)^-1 C P) A_d^T + W,     L = P C^T (C P C^T + V)^-1,

with W = int_0^T e^(A t) N e^(A^T t) dt what white noise of density N adds between two samples: a block of
exp([[-A, N], [0, A^T]] T), exact (Van Loan 1978). The observer of reduced order takes what is measured for the state itself and
estimates the rest alone. With z = (measured, rest) in blocks its equation is of the rest's order,

    P = A_22 P A_22^T + W'_22 - X Y^-1 X^T,   Y = A_12 P A_12^T + W'_11,   X = A_22 P A_12^T + W'_21,   L = [1; X Y^-1],

where W' = W + A_.1 V A_.1^T + [V, 0; 0, 0]: what a reading is off stands in the step that it begins and in the one that it ends
(that both are the same number is left out; without noise, V = 0, this is the limit of the Kalman filter). All of it is computed in
twice the digits, as the regulator is.

Sources: C. F. Van Loan, Computing integrals involving the matrix exponential, IEEE Trans. Automat. Control 23 (1978) 395-404;
B. D. O. Anderson, J. B. Moore, Optimal Filtering (1979), chapters 4 and 7.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from phichain.control.equations import wide
from phichain.control.equations.doubling import settled_wide
from phichain.control.equations.sampled import exponential
from phichain.control.equations.wide import Wide
from phichain.control.weights import Spectrum, ordered, spectrum
from phichain.records import Held
from phichain.system import Vector


@dataclass(frozen=True, eq=False)
class Filter(Held):
    """A stationary observer.

    Attributes:
        L: Correction (n, ny).
        poles: log(z) / sample of the eigenvalues z that errors of the estimate have (n,), or (n - ny,) where what is measured is
            exact; slowest first, 1/s.
        spread: Standard deviations (n,) of the estimate after a measurement.
    """

    L: Vector
    poles: Spectrum
    spread: Vector


def gathered(A: Vector, density: Vector, sample: float) -> Wide:
    """W (n, n): the covariance that white noise of a density (n, n) gathers in `sample` seconds."""
    n = len(A)
    whole = np.zeros((2 * n, 2 * n))
    whole[:n, :n], whole[:n, n:], whole[n:, n:] = -A, density, A.T
    flow = exponential(whole, sample)
    return _symmetric(flow[n:, n:].T @ flow[:n, n:])


def kalman(a: Wide, C: Vector, W: Wide, V: Vector, sample: float) -> Filter:
    """The stationary Kalman filter.

    Args:
        a: A_d (n, n).
        C: What is measured (ny, n).
        W: Covariance of what is added between two samples (n, n).
        V: Covariance of a measurement (ny, ny), positive definite.
        sample: Seconds between two samples.

    Raises:
        LinAlgError: There is none: a mode is not seen, or not disturbed.
    """
    c, noise = Wide.of(C), Wide.of(V)
    P = settled_wide((a.T, c.T @ wide.inverse(noise) @ c, W))
    L = P @ c.T @ wide.inverse(c @ P @ c.T + noise)
    kept = Wide.of(np.eye(len(C.T))) - L @ c
    return _checked(L, kept @ a, kept @ P, sample)


def reduced(a: Wide, C: Vector, W: Wide, V: Vector, sample: float) -> Filter:
    """The observer of reduced order: what is measured is taken as it is, the rest is estimated.

    Args:
        a: A_d (n, n).
        C: What is measured (ny, n), one signed entry of z each.
        W: Covariance of what is added between two samples (n, n).
        V: Covariance of a measurement (ny, ny).
        sample: Seconds between two samples.

    Raises:
        LinAlgError: There is none: a mode is not seen, or not disturbed.
    """
    ny, n = C.shape
    seen = [int(k) for k in np.argmax(np.abs(C), axis=1)]
    rest = [k for k in range(n) if k not in seen]
    signs = Wide.of(np.diag([float(C[i, k]) for i, k in enumerate(seen)]))
    a12, a22 = a[np.ix_(seen, rest)], a[np.ix_(rest, rest)]
    into = a @ Wide.of(C).T
    W = W + into @ Wide.of(V) @ into.T + Wide.of(C).T @ Wide.of(V) @ Wide.of(C)
    w11, w21, w22 = W[np.ix_(seen, seen)], W[np.ix_(rest, seen)], W[np.ix_(rest, rest)]
    # The part of the noise that what is measured shows at once is no noise of the rest.
    shown = w21 @ wide.inverse(w11)
    free = a22 - shown @ a12
    P = settled_wide((free.T, a12.T @ wide.inverse(w11) @ a12, _symmetric(w22 - shown @ w21.T)))
    own = (a22 @ P @ a12.T + w21) @ wide.inverse(a12 @ P @ a12.T + w11)
    high = np.zeros((n, ny))
    low = np.zeros((n, ny))
    turned = own @ signs
    high[seen], high[rest], low[rest] = signs.high, turned.high, turned.low
    spread = np.zeros((n, n))
    spread[np.ix_(rest, rest)] = P.high
    return _checked(Wide(high, low), a22 - own @ a12, Wide.of(spread), sample)


def _checked(L: Wide, errors: Wide, P: Wide, sample: float) -> Filter:
    multipliers = spectrum(errors.high)
    if not (np.all(np.isfinite(L.high)) and np.max(np.abs(multipliers), initial=0.0) < 1):
        raise np.linalg.LinAlgError("errors of the estimate would not die out")
    with np.errstate(divide="ignore"):
        poles = ordered(np.asarray(np.log(multipliers) / sample, dtype=complex))
    return Filter(L.high, poles, np.sqrt(np.maximum(np.diag(P.high), 0.0)))


def _symmetric(matrix: Wide) -> Wide:
    return (matrix + matrix.T) * 0.5
