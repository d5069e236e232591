"""Weighted least squares over growing horizons, by SciPy's trust region within bounds."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from scipy.optimize import least_squares

from phichain.errors import ConvergenceError
from phichain.identification.model import Model
from phichain.identification.shooting import joined
from phichain.records import Held
from phichain.system import Vector

_FIRST: Final = 32
"""The first horizon is this fraction of the data; each further one is twice as long."""
_TRUST: Final = 0.5
"""How far, in their scales, the unknowns are believed to lie from their start while the horizon grows."""
_GUESSED_NOISE: Final = 0.01
"""Noise while the horizon grows, relative to the size of a column."""
_LEAST_NOISE: Final = 1e-13
"""Noise that a column has at least, relative to its size: round-off of the flow."""
_REWEIGHTED: Final = 2
_MOST_ITERATIONS: Final = 60
_GROWN: Final = 1e-4
"""Singular value of J, over the largest, from which on the motion is fitted in pieces, too."""
_NO_WORSE: Final = 1e-6
_EXPLAINED: Final = 0.5
"""A column of which more than this is left over, relative to its spread, was not explained."""


@dataclass(frozen=True, eq=False)
class Solution(Held):
    """Where least squares came to rest.

    Attributes:
        z: The unknowns (k,), scaled.
        columns: J there (m c, k), over the noise of each row.
        predicted: The measured columns as predicted (m, c).
        noise: Standard deviation of every measured column (c,), from its residuals.
        iterations: Evaluations of J.
        root: L (k, k) with L L^T the covariance of z, where J would lose it; else None.
    """

    z: Vector
    columns: Vector
    predicted: Vector
    noise: Vector
    iterations: int
    root: Vector | None = None


def solve(model: Model) -> Solution:
    """Minimise sum_ic ((y_ic - y_c(t_i; z)) / sigma_c)^2 over z.

    The horizon grows from a 32nd of the data to all, as the motion may be chaotic and its misfit full of valleys; meanwhile a weak belief in
    the start holds what a short stretch does not tell. With all data there is no belief, and sigma_c comes from the residuals, twice over.

    Raises:
        ConvergenceError: SciPy's optimiser failed, or what it found does not explain a column.
    """
    values = np.asarray(model.data.values)
    rows, size = len(values), _sizes(values)
    z, iterations = np.array(model.unknowns.z), 0
    least = -(-4 * len(z) // values.shape[1])
    horizons = [rows // k for k in _powers(_FIRST) if rows // k >= max(8, least)]
    for horizon in [*horizons, rows]:
        z, count = _minimised(model, z, horizon, _GUESSED_NOISE * size, model.unknowns.z, 1e-5)
        iterations += count
    noise = _GUESSED_NOISE * size
    for _ in range(1 + _REWEIGHTED):
        z, count = _minimised(model, z, rows, noise, None, 1e-12)
        iterations += count
        residual = model.predicted(z, rows) - values
        noise = np.maximum(_deviation(residual, len(z)), _LEAST_NOISE * size)
    _demand_explained(model, residual, values)
    found = Solution(z, weighted(model, z, noise), residual + values, noise, iterations)
    return _settled(model, found) if model.is_exact and _is_grown(found.columns) else found


def _is_grown(columns: Vector) -> bool:
    """Whether one direction is told so much better than another that no step of SciPy's goes along the latter."""
    sizes = np.linalg.svd(columns / np.linalg.norm(columns, axis=0), compute_uv=False)
    return bool(sizes[-1] < _GROWN * sizes[0])


def _settled(model: Model, found: Solution) -> Solution:
    """The same over pieces that join, if they do and leave no more."""
    values, noise, z, count = np.asarray(model.data.values), found.noise, found.z, found.iterations
    for _ in range(1 + _REWEIGHTED):
        pieces = joined(model, z, noise)
        count += pieces.iterations
        residual = pieces.predicted - values
        if not pieces.is_settled or not np.sum((residual / found.noise) ** 2) < (1 + _NO_WORSE) * np.sum(((found.predicted - values) / found.noise) ** 2):
            return found
        z, noise = pieces.z, np.maximum(_deviation(residual, len(z)), _LEAST_NOISE * _sizes(values))
    return Solution(z, weighted(model, z, noise), pieces.predicted, noise, count, pieces.root)


def weighted(model: Model, z: Vector, noise: Vector | None = None, rows: int | None = None) -> Vector:
    """J at a point (m c, k) of the first m rows, each over its noise; over the size of its column unless that is given."""
    values = np.asarray(model.data.values)
    sizes = _sizes(values) if noise is None else noise
    return (model.columns(z, rows or len(values), fine=True) / sizes[:, None]).reshape(-1, len(z))


def _powers(first: int) -> list[int]:
    return [first >> k for k in range(first.bit_length() - 1)]


def _sizes(values: Vector) -> Vector:
    """The spread of every column; its size where it does not move, one where it is zero."""
    spread, size = np.std(values, axis=0), np.max(np.abs(values), axis=0)
    return np.where(spread > 1e-12 * size, spread, np.where(size > 0, size, 1.0))


def _deviation(residual: Vector, count: int) -> Vector:
    """Standard deviation per column, the unknowns taken off in equal shares."""
    rows, columns = residual.shape
    found: Vector = np.sqrt(np.sum(residual**2, axis=0) / max(rows - count / columns, 1.0))
    return found


def _minimised(model: Model, z: Vector, rows: int, noise: Vector, believed: Vector | None, tol: float) -> tuple[Vector, int]:
    values = np.asarray(model.data.values)[:rows]
    belief = np.eye(len(z)) / _TRUST

    def residuals(z: Vector) -> Vector:
        off = ((model.predicted(z, rows) - values) / noise).ravel()
        return off if believed is None else np.concatenate([off, belief @ (z - believed)])

    def columns(z: Vector) -> Vector:
        slopes = (model.columns(z, rows) / noise[:, None]).reshape(-1, len(z))
        return slopes if believed is None else np.concatenate([slopes, belief])

    low = np.asarray(model.unknowns.low)
    inside = np.maximum(z, np.where(np.isfinite(low), low + 1e-9, low))
    try:
        with np.errstate(all="ignore"):
            found: Any = least_squares(
                residuals, inside, columns, bounds=(low, np.inf), method="trf", x_scale="jac",
                ftol=tol, xtol=tol, gtol=tol, max_nfev=_MOST_ITERATIONS,
            )  # fmt: skip
    except (ValueError, np.linalg.LinAlgError) as failure:
        raise ConvergenceError("fit", str(failure), "the optimiser left the motions that can be followed", "start from likelier values") from failure
    return np.asarray(found.x, dtype=float), int(found.njev)


def _demand_explained(model: Model, residual: Vector, values: Vector) -> None:
    left = np.sqrt(np.mean(residual**2, axis=0)) / _sizes(values)
    if not (left < _EXPLAINED).all():
        worst = int(np.argmax(np.nan_to_num(left, nan=np.inf)))
        raise ConvergenceError(
            "fit", model.data.columns[worst], f"leaves {100 * left[worst]:.3g} % of the column's spread unexplained",
            "start from likelier values, shorten the data, or ask whether the scene is the chain that was measured",
            column=model.data.columns[worst], left=float(left[worst]),
        )  # fmt: skip
