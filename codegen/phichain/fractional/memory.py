"""The short-memory principle, equation (4), with its bound put right.

A derivative of order alpha > 0 forgets: with |f| <= M, cutting the memory at length L changes it by at most

    |D^alpha f - D^alpha_(t-L) f| <= M L^-alpha / |Gamma(1 - alpha)|,

so a relative error delta_0 = |error| / M needs L >= (1 / (delta_0 |Gamma(1 - alpha)|))^(1/alpha). The paper prints
L >= 1 / (delta_0^2 Gamma(alpha)), whose power of delta_0 is right at alpha = 1/2 alone. An integral (alpha < 0) never
forgets, its weights have no finite sum: whatever is cut off is lost, and truncation is refused.

For the sum over K + 1 samples the cut tail is known exactly, since all its weights have one sign from k > alpha on:

    sum_(k>K) |w_k| = Gamma(K + 1 - alpha) / (|Gamma(1 - alpha)| Gamma(K + 1)).

Source: I. Podlubny, Fractional Differential Equations (1999), section 7.3.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.signal import oaconvolve
from scipy.special import poch, rgamma

from phichain.errors import SignalError, ToleranceError
from phichain.fractional.signals import finite_signal, real_number, supported_orders, uniform_step
from phichain.records import Held

Vector = NDArray[np.float64]

# A length that equals the bound but for its rounding passes.
_SLACK = 1e-12


@dataclass(frozen=True)
class ShortMemory(Held):
    """A Gruenwald-Letnikov derivative with a short memory.

    Attributes:
        time: Sample times, s, shape (n,).
        alpha: Order of differentiation.
        values: The derivative, shape (n,) or (n, C).
        length: The memory L, s, a whole number of steps.
        implied_error: Bound on |truncated - untruncated| / max |f| for this grid, s^-alpha.
    """

    time: Vector
    alpha: float
    values: Vector
    length: float
    implied_error: float


def memory_length(alpha: float, tolerance: float) -> float:
    """Shortest memory L, s, whose error is within tolerance x max |f|: (1 / (delta_0 |Gamma(1-alpha)|))^(1/alpha).

    Args:
        alpha: Order of differentiation, > 0. Whole orders have no memory: 0 comes back.
        tolerance: delta_0, in s^-alpha.

    Raises:
        SignalError: alpha <= 0 or above the supported range.
        ToleranceError: The tolerance is not positive, or no memory of a finite length keeps it.
        ArrayError: An argument is no number.
    """
    alpha = _refuse_integrals(alpha)
    if not 0.0 < (tolerance := real_number("tolerance", tolerance)) < np.inf:
        raise ToleranceError(
            "tolerance", tolerance, "must be positive and finite", "pass a relative error such as 1e-3"
        )
    with np.errstate(over="ignore"):
        length = float((abs(rgamma(1.0 - alpha)) / np.float64(tolerance)) ** (1.0 / alpha))
    if length == np.inf:
        raise ToleranceError(
            "tolerance",
            tolerance,
            f"no finite memory keeps it for alpha = {alpha:g}, which hardly forgets",
            "use `differintegrate`, which keeps the whole past",
        )
    return length


def implied_error(alpha: float, length: float) -> float:
    """Error over max |f| that a memory L leaves: L^-alpha / |Gamma(1 - alpha)|, s^-alpha.

    Raises:
        SignalError: alpha <= 0 or above the supported range, or a length that is not positive.
        ArrayError: An argument is no number.
    """
    alpha = _refuse_integrals(alpha)
    if not 0.0 < (length := real_number("length", length)) < np.inf:
        raise SignalError("length", length, "a memory must be positive and finite", "pass seconds")
    return float(abs(rgamma(1.0 - alpha)) * length**-alpha)


def short_memory(
    time: ArrayLike,
    signal: ArrayLike,
    alpha: float,
    *,
    length: float | None = None,
    tolerance: float | None = None,
) -> ShortMemory:
    """Equation (4): D^alpha f(t) from the last L seconds alone, in O(n log L).

    Args:
        time: Uniform sample times, s, shape (n,).
        signal: f, shape (n,) or (n, C).
        alpha: Order of differentiation, 0 < alpha <= 3.
        length: The memory L, s, rounded up to whole steps; None takes what the tolerance needs.
        tolerance: Admitted error over max |f|, s^-alpha; None admits what the length implies.

    Raises:
        ToleranceError: The length is below what the tolerance needs; the message says the error it implies.
        SignalError: An integral (alpha <= 0), neither length nor tolerance, or a signal that cannot be used.
    """
    alpha = _refuse_integrals(alpha)
    elapsed, step = uniform_step(time)
    rows = finite_signal(signal, elapsed.size, 2)
    needed = 0.0 if tolerance is None else memory_length(alpha, tolerance)
    if length is None and tolerance is None:
        raise SignalError(
            "length", None, "neither a memory length nor a tolerance is given", "pass one of them"
        )
    error = 0.0 if length is None else implied_error(alpha, length)
    if length is not None and tolerance is not None and length < needed * (1.0 - _SLACK):
        raise ToleranceError(
            "length",
            length,
            f"this memory implies a relative error of {error:.3g}, above the tolerance {tolerance:g}",
            f"use at least {needed:.6g} s",
            implied_error=error,
            bound=needed,
        )
    last = max(ceil(alpha), ceil((needed if length is None else length) / step * (1.0 - _SLACK)))
    if tolerance is not None:
        last = _lengthened(alpha, step, last, tolerance)
    values = _truncated(rows, alpha, min(last, elapsed.size - 1)) * step**-alpha
    shaped = values[0] if np.ndim(signal) == 1 else values.T
    cut = _tail(alpha, last) * step**-alpha
    return ShortMemory(np.asarray(time, dtype=float), float(alpha), shaped, last * step, cut)


def _lengthened(alpha: float, step: float, last: int, tolerance: float) -> int:
    # The bound is the continuous operator's; for alpha > 1 the sum needs about (alpha - 1)/2 samples more.
    while _tail(alpha, last) * step**-alpha > tolerance * (1.0 + _SLACK):
        last += 1
    return last


def _truncated(rows: Vector, alpha: float, last: int) -> Vector:
    weights = np.cumprod(np.concatenate([[1.0], 1.0 - (alpha + 1.0) / np.arange(1, last + 1)]))
    return np.stack([oaconvolve(row, weights)[: row.size] for row in rows])


def _tail(alpha: float, last: int) -> float:
    """sum_(k>K) |w_k|; for whole alpha nothing follows k = alpha."""
    if alpha == round(alpha):
        return 0.0
    return float(abs(rgamma(1.0 - alpha)) / poch(last + 1.0 - alpha, alpha))


def _refuse_integrals(alpha: float) -> float:
    """The order as a double, if it differentiates."""
    supported_orders(alpha)
    alpha = real_number("alpha", alpha)
    if alpha <= 0.0:
        raise SignalError(
            "alpha",
            alpha,
            "an integral keeps its whole memory and cannot be truncated",
            "use `differintegrate`, or differentiate (alpha > 0)",
        )
    return alpha
