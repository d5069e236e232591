"""Checks that stand between a caller's arrays and the quadratures: uniform grids, finite samples, supported orders."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from phichain.errors import ArrayError, SignalError
from phichain.system.arrays import reals

Vector = NDArray[np.float64]

# The supported orders of differintegration: threefold integrals to third derivatives.
ALPHA_MIN, ALPHA_MAX = -3.0, 3.0
# A grid counts as uniform when no time strays from t_0 + n h by more than this fraction of h, or by its own rounding.
_JITTER = 1e-9


def uniform_step(time: ArrayLike) -> tuple[Vector, float]:
    """The times, counted from the first sample, and their step h.

    Args:
        time: Sample times in s, increasing, shape (n,).

    Returns:
        t_n = n h with t_0 = 0, shape (n,), and h = (last - first) / (n - 1).

    Raises:
        SignalError: Fewer than two times, times that are not finite, do not increase or are not evenly spaced.
    """
    times = real_array("time", time)
    if times.ndim != 1 or times.size < 2:
        raise SignalError(
            "time", times.shape, "a grid needs at least two times in one dimension", "pass sample times"
        )
    if not np.all(np.isfinite(times)):
        raise SignalError("time", times, "holds times that are not finite", "pass finite sample times")
    step = float(times[-1] - times[0]) / (times.size - 1)
    if step <= 0.0:
        raise SignalError("time", step, "the times do not increase", "sort the samples by time")
    stray = np.abs(times - times[0] - step * np.arange(times.size))
    worst = int(np.argmax(stray))
    if stray[worst] > _JITTER * step + 4.0 * np.finfo(float).eps * np.max(np.abs(times)):
        raise SignalError(
            "time",
            float(times[worst]),
            f"the grid is not uniform: sample {worst} lies {stray[worst] / step:.3g} steps beside its place",
            "resample it, e.g. `trajectory.resample(1001)`",
            index=worst,
        )
    return np.arange(times.size, dtype=float) * step, step


def finite_signal(signal: ArrayLike, size: int, shortest: int) -> Vector:
    """A signal as rows of channels, shape (C, n).

    Args:
        signal: Samples, shape (n,) or (n, C).
        size: n, the number of times.
        shortest: The fewest samples the caller can use.

    Raises:
        ArrayError: Another shape, or values that are not real numbers.
        SignalError: Too few samples, or samples that are not finite.
    """
    values = real_array("signal", signal)
    if values.ndim not in (1, 2) or values.shape[0] != size:
        raise ArrayError(
            "signal",
            values.shape,
            f"must be ({size},) or ({size}, channels), as the times are",
            "pass one row per time",
        )
    if size < shortest:
        raise SignalError(
            "signal",
            size,
            f"too short: {shortest} samples are needed to start",
            "pass a longer signal or lower the order",
        )
    bad = np.argwhere(~np.isfinite(values))
    if bad.size:
        first = tuple(int(i) for i in bad[0])
        raise SignalError(
            "signal",
            float(values[first]),
            f"{len(bad)} sample(s) are not finite, the first at index {first[0] if values.ndim == 1 else first}",
            "cut the signal before it or repair it",
            index=first[0],
        )
    rows = values[None, :] if values.ndim == 1 else values.T
    return np.ascontiguousarray(rows)


def supported_orders(alpha: ArrayLike, low: float = ALPHA_MIN, high: float = ALPHA_MAX) -> Vector:
    """The orders alpha as a vector, shape (A,).

    Raises:
        SignalError: An order is not finite or outside [low, high].
        ArrayError: Not real numbers in at most one dimension.
    """
    orders = np.atleast_1d(real_array("alpha", alpha))
    if orders.ndim != 1 or orders.size == 0:
        raise ArrayError(
            "alpha",
            orders.shape,
            "must be one number or a vector of them",
            "pass the orders in one dimension",
        )
    outside = ~((orders >= low) & (orders <= high))
    if np.any(outside):
        raise SignalError(
            "alpha",
            float(orders[np.argmax(outside)]),
            f"lies outside the supported range [{low:g}, {high:g}]",
            "negative orders integrate, positive ones differentiate: choose one within",
        )
    return orders


def real_number(field: str, value: object) -> float:
    """One number as a double.

    Raises:
        ArrayError: It is no single real number.
    """
    array = reals(field, value, "pass a float")
    if array.ndim or isinstance(value, bool):
        raise ArrayError(field, value, "must be one real number", "pass a float")
    return float(array)


def real_array(field: str, values: ArrayLike) -> Vector:
    """Values as doubles.

    Raises:
        ArrayError: They are complex, ragged or no numbers.
    """
    return reals(field, values, "pass floats")
