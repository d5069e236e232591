"""Fractional derivatives and integrals of sampled signals: equations (1)-(5) of paper A, at any order of accuracy.

    D^alpha f(t) = lim_(h->0) h^-alpha sum_(k>=0) (-1)^k C(alpha, k) f(t - k h)                                  (1)

with the lower terminal at the first sample. `grunwald_letnikov` is (2)-(3) as they stand: the limit left out, one step
h for sum bounds and samples (the paper prints h in the bounds and T in the samples). `differintegrate` is Lubich's
convolution quadrature of order 1 to 6 with starting corrections, so that smooth signals converge at the stated order
on the whole interval, whatever their values at t = 0. Both do all orders alpha at once, by FFT.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import rgamma

from phichain.archive import COUNT, TRUTH, Schema, read_archive, real
from phichain.errors import ArrayError, SignalError
from phichain.fractional import weights as lubich
from phichain.fractional.convolution import SCRATCH, Signal, convolve, convolve_short, transform
from phichain.fractional.series import difference_weights
from phichain.fractional.signals import finite_signal, real_array, supported_orders, uniform_step
from phichain.fractional.threads import run
from phichain.records import Held, write_csv, write_npz

Vector = NDArray[np.float64]

_SCHEMA = Schema(
    "Differintegral",
    {"time": real("n"), "alpha": real("orders"), "values": real("orders", "n", further="channels")},
    {"order": COUNT, "starting": COUNT, "initial": TRUTH},
    filled=("n", "orders"),
)

# Samples of kernels transformed together: enough to share the overhead, few enough to stay near the cache.
_CHUNK_VALUES = 2**17
# Bytes that orders under way may take together, beside the values: with many cores not all of them work on long signals.
_MOST_SCRATCH = 2**26


@dataclass(frozen=True)
class Differintegral(Held):
    """D^alpha of a signal for many alpha.

    Attributes:
        time: Sample times, s, shape (n,).
        alpha: Orders of differintegration, shape (A,).
        values: D^alpha f, shape (A, n) or (A, n, C) as the signal was; units of f times s^-alpha. Where D^alpha f is
            unbounded, at t = 0, the sample is NaN.
        order: Order of convergence of the quadrature.
        starting: Starting values used, 0 for the plain Gruenwald-Letnikov sum.
        initial: Whether initial-value terms were added.
    """

    time: Vector
    alpha: Vector
    values: Vector
    order: int
    starting: int
    initial: bool

    def __str__(self) -> str:
        method = f"convolution quadrature of order {self.order}" if self.starting else "Gruenwald-Letnikov"
        terms = " with initial terms" if self.initial else ""
        return (
            f"D^alpha{terms} for {self.alpha.size} alpha in [{self.alpha.min():g}, {self.alpha.max():g}] "
            f"at {self.time.size} times by {method}"
        )

    def at(self, alpha: float) -> Vector:
        """The values of the stored order nearest to alpha, shape (n,) or (n, C)."""
        result: Vector = self.values[int(np.argmin(np.abs(self.alpha - alpha)))]
        return result

    def to_csv(self, path: str | Path) -> None:
        """Write one row per time, one column per alpha (and channel)."""
        columns = {"t": self.time}
        for a, table in zip(self.alpha, self.values, strict=True):
            channels = (
                {f"alpha={float(a)!r}": table}
                if table.ndim == 1
                else {f"alpha={float(a)!r},{c + 1}": table[:, c] for c in range(table.shape[1])}
            )
            columns.update(channels)
        write_csv(path, columns, self)

    def to_npz(self, path: str | Path) -> Path:
        """Write everything, exactly."""
        meta = {
            "kind": "Differintegral",
            "order": self.order,
            "starting": self.starting,
            "initial": self.initial,
        }
        return write_npz(path, {"time": self.time, "alpha": self.alpha, "values": self.values}, meta)

    @classmethod
    def from_npz(cls, path: str | Path) -> Differintegral:
        """Read what `to_npz` wrote.

        Raises:
            OutputError: The file is missing or holds no Differintegral, or not a whole one.
        """
        arrays, meta = read_archive(path, _SCHEMA)
        return cls(
            arrays["time"], arrays["alpha"], arrays["values"], meta["order"], meta["starting"], meta["initial"]
        )


def grunwald_letnikov(
    time: ArrayLike,
    signal: ArrayLike,
    alpha: ArrayLike,
    *,
    initial: tuple[ArrayLike, ArrayLike] | None = None,
    workers: int | None = None,
) -> Differintegral:
    """Equations (2)-(3): D^alpha f(t_n) = h^-alpha sum_(k=0..n) (-1)^k C(alpha, k) f(t_n - k h), for all alpha at once.

    First order in h at fixed t > 0. Where f(0) != 0 and -1 < alpha the error at t_n is of order h^-alpha n^(-alpha-1):
    near t = 0 the sum converges at order -alpha only, for alpha > 0 not at all; `differintegrate` has no such layer.

    Args, returns and raises as for `differintegrate`.
    """
    return _quadrature(time, signal, alpha, 1, False, initial, workers)


def differintegrate(
    time: ArrayLike,
    signal: ArrayLike,
    alpha: ArrayLike,
    *,
    order: int = 4,
    initial: tuple[ArrayLike, ArrayLike] | None = None,
    workers: int | None = None,
) -> Differintegral:
    """D^alpha f by convolution quadrature with starting corrections, for all alpha at once.

    The error is of order h^p uniformly in t for signals with p + max(0, alpha) derivatives; for a signal with a kink,
    or one sampled with noise, a low order is the better choice. Round-off is a few eps of the largest value an
    integral can reach by time 4 t, and a few eps |f| h^-alpha in a derivative, which no method avoids.

    Args:
        time: Uniform sample times, s, shape (n,); the first is the lower terminal.
        signal: f at those times, shape (n,) or (n, C).
        alpha: Orders of differintegration in [-3, 3]: negative ones integrate, positive ones differentiate; a number
            or shape (A,).
        order: p, 1 to 6.
        initial: (theta(0), theta'(0)) of the motion whose second derivative the signal is, per channel; adds, for
            alpha in [-2, 0],

                theta'(0) t^(-1-alpha) / Gamma(-alpha) + theta(0) t^(-2-alpha) / Gamma(-1-alpha),

            so that alpha = -2 gives theta and alpha = 0 the signal. In between the sum is unbounded at t = 0 and that
            sample is NaN (at alpha = -1 too, where it would be theta'(0): one rule for a whole surface).
        workers: Threads; None takes one per available core. The result does not depend on it.

    Returns:
        The record of all values. For alpha > 0, not an integer, the sample at t = 0 is NaN where D^alpha f is
        unbounded, and 0 where f and its derivatives below alpha start at zero, as far as the samples tell.

    Raises:
        SignalError: The grid is not uniform, the signal too short or not finite, alpha or the order unsupported.
        ArrayError: Shapes that do not fit, or values that are not real.
    """
    if isinstance(order, bool) or order not in lubich.ORDERS:
        raise SignalError("order", order, "there is no such quadrature", f"choose one of {lubich.ORDERS}")
    return _quadrature(time, signal, alpha, order, True, initial, workers)


def _quadrature(
    time: ArrayLike,
    signal: ArrayLike,
    alpha: ArrayLike,
    order: int,
    corrected: bool,
    initial: tuple[ArrayLike, ArrayLike] | None,
    workers: int | None,
) -> Differintegral:
    elapsed, step = uniform_step(time)
    orders = supported_orders(alpha)
    starting = max(lubich.starting_values(order, float(a)) for a in orders) if corrected else 1
    rows = finite_signal(signal, elapsed.size, starting + 1)
    values = _all_orders(transform(rows), step, orders, order, corrected, workers)
    if initial is not None:
        _add_initial_terms(values, elapsed, orders, initial)
    shaped = values[0] if np.ndim(signal) == 1 else np.moveaxis(values, 0, -1)
    return Differintegral(
        np.asarray(time, dtype=float),
        orders,
        shaped,
        order,
        starting if corrected else 0,
        initial is not None,
    )


def _all_orders(
    signal: Signal, step: float, orders: Vector, order: int, corrected: bool, workers: int | None
) -> Vector:
    channels, size = signal.samples.shape
    values = np.empty((channels, orders.size, size))
    basis = lubich.Basis(order, size)
    whole = (orders >= 0) & (orders == np.round(orders))
    for member in np.flatnonzero(whole):
        values[:, member] = (
            _derivative(signal, order, int(orders[member]), corrected) * step ** -orders[member]
        )
    counts = np.array([lubich.starting_values(order, float(a)) for a in orders])
    tasks = []
    for starting in np.unique(counts[~whole]):
        members = np.flatnonzero((counts == starting) & ~whole)
        rule = lubich.quadrature(order, int(starting), orders[members], size)
        starts = [lubich.start(samples, int(starting), basis) for samples in signal.samples if corrected]
        for rows in _runs(members, max(1, _CHUNK_VALUES // size)):
            # Neighbours in the result, so that they are summed where they stay.
            out = values[:, members[rows.start] : members[rows.stop - 1] + 1]
            tasks.append(partial(_some_orders, out, signal, step, rule, rows, basis, starts))
    run(tasks, workers, most=_MOST_SCRATCH // (SCRATCH * size))
    return values


def _runs(members: NDArray[np.intp], longest: int) -> Iterator[slice]:
    """Pieces of a rising sequence of indices, each without a gap and of at most `longest`."""
    first = 0
    for stop in range(1, members.size + 1):
        if stop == members.size or members[stop] != members[stop - 1] + 1 or stop - first == longest:
            yield slice(first, stop)
            first = stop


def _some_orders(
    out: Vector,
    signal: Signal,
    step: float,
    rule: lubich.Quadrature,
    rows: slice,
    basis: lubich.Basis,
    starts: list[lubich.Start],
) -> None:
    """Set the values (C, rows, n) of orders that need the whole past."""
    convolve(signal, lubich.weights(rule, rows, basis), out)
    for channel, start in enumerate(starts):
        lubich.correct(out[channel], rule, rows, basis, start)
    out *= (step ** -rule.alpha[rows])[:, None]


def _derivative(signal: Signal, order: int, alpha: int, corrected: bool) -> Vector:
    """Derivative of degree 0, 1, 2, .. in units of the step: backward differences of p alpha + 1 samples, (C, n)."""
    starting = lubich.starting_values(order, alpha)
    taps = min(order * alpha + 1, signal.samples.shape[1])
    kernel = lubich.quadrature(order, starting, np.array([float(alpha)]), taps).head[0]
    result = convolve_short(signal, kernel)
    for n in range(taps - 1 if corrected else 0):
        # One sample more than the order needs, so that the one-sided start does not outweigh the rest.
        result[:, n] = _window_derivative(signal, starting + 1, alpha, n)
    return result


def _window_derivative(signal: Signal, width: int, alpha: int, n: int) -> Vector:
    """Derivative at sample n, in units of the step, of the polynomial through the `width` samples up to n; (C,)."""
    first = max(0, n - width + 1)
    weights = difference_weights(width, alpha, n - first)
    result: Vector = signal.samples[:, first : first + width] @ weights
    return result


def _add_initial_terms(
    values: Vector, elapsed: Vector, orders: Vector, initial: tuple[ArrayLike, ArrayLike]
) -> None:
    """Add theta'(0) t^(-1-alpha) / Gamma(-alpha) + theta(0) t^(-2-alpha) / Gamma(-1-alpha) to values (C, A, n)."""
    supported_orders(orders, -2.0, 0.0)
    if not isinstance(initial, (tuple, list)) or len(initial) != 2:
        raise ArrayError("initial", initial, "is no pair of initial values", "pass (theta(0), theta'(0))")
    start, rate = (_per_channel("initial", part, values.shape[0]) for part in initial)
    by_rate, by_start = rgamma(-orders), rgamma(-1.0 - orders)
    log_t = np.log(elapsed[1:])
    for k, alpha in enumerate(orders):
        powers = by_rate[k] * np.exp((-1.0 - alpha) * log_t), by_start[k] * np.exp((-2.0 - alpha) * log_t)
        values[:, k, 1:] += rate[:, None] * powers[0] + start[:, None] * powers[1]
    inside = (orders > -2.0) & (orders < 0.0)
    values[:, inside, 0] = np.nan
    values[:, orders == -2.0, 0] += start[:, None]


def _per_channel(field: str, part: ArrayLike, channels: int) -> Vector:
    given = real_array(field, part)
    if given.ndim > 1 or given.size not in (1, channels):
        raise ArrayError(
            field, given.shape, f"needs one value per channel, {channels}", "pass (theta(0), theta'(0))"
        )
    if not np.all(np.isfinite(given)):
        raise SignalError(field, given, "holds values that are not finite", "pass finite initial values")
    return np.broadcast_to(given, (channels,))
