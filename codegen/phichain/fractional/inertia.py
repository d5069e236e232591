"""Fractional powers of a chain's inertia matrix: theta_p = (I^-1)^p u for many p along a trajectory.

Section 4 of paper A follows a signal through (15): u = T - N - G turns into theta'' = I^-1 u, and (I^-1)^p, 0 <= p <= 1,
shows the way in between. I is symmetric positive definite, I = F^T F with the factor F = diag(sqrt(m_a)) J_a of the
masses' position Jacobians, so with F = W diag(sigma) V^T

    (I^-1)^p u = V diag(sigma^(-2p)) V^T u.

Everything is taken from F (see `jacobi`): at a mass ratio of 1e8 an eigendecomposition of I is wrong by 4e-6, this by
1e-14.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from phichain.errors import ArrayError, SignalError
from phichain.fractional.factor import absolute_factor, coordinates, refuse_spatial, states_of
from phichain.fractional.jacobi import right_singular_system
from phichain.fractional.signals import real_array
from phichain.fractional.threads import run
from phichain.records import Held
from phichain.system import Parameters, System

Vector = NDArray[np.float64]
Receiver = Callable[[int, NDArray[Any]], object]

# States decomposed, and states whose powers are formed, in one piece: their arrays stay in the cache.
_DECOMPOSED = 4096
_POWERED_VALUES = 2**17


@dataclass(frozen=True, eq=False)
class InertiaSpectrum(Held):
    """The inertia matrices of many states as V diag(sigma^2) V^T.

    Attributes:
        sigma: Singular values of the factor, shape (S, nv), kg^(1/2) m for angles.
        vectors: V, shape (S, nv, nv), its columns along sigma.
    """

    sigma: Vector
    vectors: Vector

    def __str__(self) -> str:
        spread = float(np.max(self.sigma.max(axis=1) / self.sigma.min(axis=1)))
        return f"inertia spectra of {len(self.sigma)} states, nv = {self.sigma.shape[1]}, worst cond I = {spread**2:.2g}"


def inertia_spectrum(
    system: System, q: ArrayLike, p: Parameters | None = None, *, workers: int | None = None
) -> InertiaSpectrum:
    """Decompose the inertia matrices of many states by one-sided Jacobi.

    Args and raises as for `inertia_factor`; workers: threads, None takes one per core.
    """
    states = states_of(system, "q", q, system.nq).T
    refuse_spatial(system)
    absolute = partial(absolute_factor, system, p=p)
    return _decompose(absolute, states, coordinates(system), workers)


def factor_spectrum(factor: ArrayLike, *, workers: int | None = None) -> InertiaSpectrum:
    """The same from any factors F, shape (S, M, n) with M >= n, of matrices F^T F.

    Raises:
        ArrayError: Another shape.
        SignalError: A factor is not finite.
        ConvergenceError: A factor has not full column rank.
    """
    values = real_array("factor", factor)
    if values.ndim != 3 or values.shape[1] < values.shape[2] or values.shape[2] == 0:
        raise ArrayError(
            "factor", values.shape, "must be (states, M, n) with M >= n", "stack one factor per state"
        )
    if not np.all(np.isfinite(values)):
        raise SignalError("factor", values, "holds values that are not finite", "cut the states before them")
    return _decompose(np.ascontiguousarray, np.moveaxis(values, 0, -1), np.eye(values.shape[2]), workers)


def _decompose(
    factor_of: Callable[[Vector], Vector], states: Vector, relation: Vector, workers: int | None
) -> InertiaSpectrum:
    count, size = states.shape[-1], relation.shape[0]
    all_sigma, all_vectors = np.empty((count, size)), np.empty((count, size, size))

    def decompose(first: int) -> None:
        piece = slice(first, first + _DECOMPOSED)
        sigma, vectors = right_singular_system(factor_of(states[..., piece]), relation)
        all_sigma[piece] = sigma.T
        all_vectors[piece] = np.moveaxis(vectors, -1, 0)

    run([partial(decompose, first) for first in range(0, count, _DECOMPOSED)], workers)
    return InertiaSpectrum(all_sigma, all_vectors)


def inertia_powers(
    spectrum: InertiaSpectrum,
    u: ArrayLike,
    p: ArrayLike,
    *,
    acceleration: ArrayLike | None = None,
    receive: Receiver | None = None,
    dtype: type = np.float64,
    workers: int | None = None,
) -> NDArray[Any]:
    """theta_p = (I^-1)^p u = V diag(sigma^(-2p)) V^T u for every state and every p.

    Args:
        spectrum: Of the states, from `inertia_spectrum`.
        u: Generalised forces, shape (S, nv).
        p: Real exponents, shape (P,) or a number; 0 returns u, 1 the acceleration.
        acceleration: I^-1 u where it is known better, e.g. from the forward dynamics, shape (S, nv). Forces of a heavy
            link (1e8 times the others) leave in u, rounded to doubles, no digit of what moves the light ones; with
            this every mode is taken from whichever of u and I^-1 u holds more of it.
        receive: Called as ``receive(first, block)`` with block (s, P, nv) of the states first .. first + s - 1, in
            order, instead of one large result: memory stays at a few MiB whatever S x P.
        dtype: Type of the result; the arithmetic is double.
        workers: Threads; None takes one per core. With `receive` it is one.

    Returns:
        Shape (S, P, nv); with `receive` an empty array.

    Raises:
        ArrayError: Shapes that do not fit.
        SignalError: u or p is not finite.
    """
    exponents = _real_exponents(p)
    forces = _per_state(spectrum, "u", u)
    known = None if acceleration is None else _per_state(spectrum, "acceleration", acceleration)
    count, size = spectrum.sigma.shape
    piece = max(1, _POWERED_VALUES // (exponents.size * size))
    pieces = [slice(first, min(first + piece, count)) for first in range(0, count, piece)]
    if receive is not None:
        for rows in pieces:
            receive(
                rows.start, _power_piece(spectrum, forces, known, exponents, rows).astype(dtype, copy=False)
            )
        return np.empty((0, exponents.size, size), dtype=dtype)
    result: NDArray[Any] = np.empty((count, exponents.size, size), dtype=dtype)

    def fill(rows: slice) -> None:
        result[rows] = _power_piece(spectrum, forces, known, exponents, rows)

    run([partial(fill, rows) for rows in pieces], workers)
    return result


def _power_piece(
    spectrum: InertiaSpectrum, forces: Vector, known: Vector | None, exponents: Vector, rows: slice
) -> Vector:
    sigma, vectors = spectrum.sigma[rows], spectrum.vectors[rows]
    modal = np.einsum("ski,sk->si", vectors, forces[rows])
    if known is not None:
        by_acceleration = sigma * sigma * np.einsum("ski,sk->si", vectors, known[rows])
        lost = sigma * sigma * _largest(known[rows]) < _largest(forces[rows])
        modal = np.where(lost, by_acceleration, modal)
    # p runs along the last axis here: NumPy's loops are slow over a short one.
    scales = -2.0 * np.log(sigma)[:, :, None] * exponents
    np.exp(scales, out=scales)
    result: Vector = scales.swapaxes(1, 2) @ (modal[:, :, None] * vectors.swapaxes(1, 2))
    result[:, exponents == 0.0] = forces[rows, None]
    if known is not None:
        result[:, exponents == 1.0] = known[rows, None]
    return result


def _largest(rows: Vector) -> Vector:
    return np.max(np.abs(rows), axis=1, keepdims=True)


def _per_state(spectrum: InertiaSpectrum, field: str, values: ArrayLike) -> Vector:
    array = real_array(field, values)
    if array.shape != spectrum.sigma.shape:
        raise ArrayError(
            field, array.shape, f"must be (states, nv) = {spectrum.sigma.shape}", "pass one vector per state"
        )
    if not np.all(np.isfinite(array)):
        raise SignalError(field, array, "holds values that are not finite", "cut the states before them")
    return array


def _real_exponents(p: ArrayLike) -> Vector:
    exponents = np.atleast_1d(real_array("p", p))
    if exponents.ndim != 1 or not np.all(np.isfinite(exponents)):
        raise SignalError(
            "p", p, "must be finite real numbers in one dimension", "pass e.g. numpy.linspace(0, 1, 101)"
        )
    return exponents
