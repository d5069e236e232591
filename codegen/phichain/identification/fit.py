"""fit: parameters of a chain from its measured motion."""

from __future__ import annotations

import time
from collections.abc import Iterable, Mapping
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike
from scipy.stats import t as student

from phichain.errors import ArrayError, ConvergenceError, UnsupportedError
from phichain.identification.identifiable import Directions, demand_told_apart, directions
from phichain.identification.measurement import Measurement, measured
from phichain.identification.model import Model, model
from phichain.identification.record import Fit
from phichain.identification.solve import Solution, solve, weighted
from phichain.identification.unknowns import unknowns
from phichain.motion.inputs.table import BETWEEN
from phichain.system import Parameters, System, Vector
from phichain.system.arrays import reals

LEVEL: Final = 0.95
"""Probability of the confidence limits."""
_AT_BOUND: Final = 1e-5
_SHARES: Final = (1, 4, 16)
_GROWN: Final = 1e-12
"""Singular value of the columns of a solution, over the largest, that a chaotic motion may leave: what its growth has hidden is told by the rows before."""
"""Parts of the data, from the start, that are asked for what they tell."""


def fit(
    system: System,
    data: Measurement | Mapping[str, ArrayLike],
    start: Mapping[str, Any],
    *,
    fixed: Iterable[str] = (),
    p: Parameters | None = None,
    x0: ArrayLike | None = None,
    fit_start: bool = True,
    between: str = "held",
) -> Fit:
    """Find the runtime parameters with which a planar chain moves as it was measured.

    Least squares over y_c(t_i; theta, x_0) with the noise of every column estimated from its residuals; the initial state is fitted, too,
    as noise on the first row would otherwise pass for parameters. Standard errors are the roots of the diagonal of (J^T W J)^-1 at the end,
    with W the inverse squares of the noise, confidence limits theta +- t_0.975 times them. They hold for noise that is independent from row
    to row, and as far as the motion is linear in the unknowns within them. J, the columns of the parameters, is carried
    by the flow where the scene has it so, `[flow] variational = ["state", "mass"]`, and comes from central differences of it elsewhere.

    Args:
        system: The chain, planar and in double precision, with `propagate`, or `propagate_stiff` where it has no other flow or dry friction acts.
        data: What was measured: a Measurement, or columns by name, `t` and entries of the state (theta_1, theta_dot_1, x), and inputs.
        start: Starting values of the parameters to be fitted, by name; one number stands for all links.
        fixed: Numbers among them that keep their start, such as "mass_1".
        p: The values of the other runtime parameters.
        x0: Where the motion starts (nx,); by default from the first rows, and zero where nothing was measured.
        fit_start: Whether x0 is only a first guess; if not, it is taken as known.
        between: What recorded inputs do between rows: "held" or "linear".

    Returns:
        The Fit.

    Raises:
        UnsupportedError: The chain is spatial or of single precision, or nothing of it is left to run time.
        ArrayError: The data or the starting values are no such numbers (`measured`, `unknowns`), or fewer than the unknowns.
        IdentificationError: The data cannot tell the unknowns apart; it names those that move together.
        ConvergenceError: The optimiser found no motion that explains what was measured.
    """
    began = time.perf_counter()
    if not system.is_planar or system.real != "double":
        kind = system.space if not system.is_planar else system.real
        raise UnsupportedError("system", kind, "is not fitted: only planar chains in double precision are", "build such a scene")
    given = data if isinstance(data, Measurement) else measured(system, data)
    if between not in BETWEEN:
        raise ArrayError("between", between, "is no way from one row to the next", f"use {' or '.join(BETWEEN)}")
    first, sizes = _start(system, given)
    if x0 is not None:
        first = reals("x0", x0, "give q and v one after the other").copy()
        if first.shape != (system.nx,) or not np.isfinite(first).all():
            raise ArrayError("x0", first, f"is no state of {system.nx} finite numbers", "give q and v one after the other")
    sought = unknowns(system, start, p, fixed, first, sizes, fit_start)
    rows, columns = given.values.shape
    if rows * columns <= len(sought.z):
        raise ArrayError("data", rows * columns, f"holds no more numbers than the {len(sought.z)} that are unknown", "measure longer")
    made = model(system, given, sought, between)
    demand_told_apart(told(made, np.asarray(sought.z)), sought.names, sought.count)
    found = solve(made)
    return _judged(made, found, began)


def _judged(made: Model, found: Solution, began: float) -> Fit:
    """The record of a solution, with standard errors from its columns."""
    sought, system, data = made.unknowns, made.system, made.data
    seen = directions(np.asarray(found.columns), made.noise, _GROWN)
    if len(seen.blind) and found.root is None:
        demand_told_apart(told(made, np.asarray(found.z)), sought.names, sought.count)
        raise ConvergenceError(
            "data.t", float(data.t[-1] - data.t[0]), "grows small changes so far that one of them hides all others", "shorten the data"
        )
    error, correlation = errors(np.asarray(found.columns)) if found.root is None else spread(np.asarray(found.root))
    scale, z = np.asarray(sought.scale), np.asarray(found.z)
    values, error = z * scale, error * scale
    reach = float(student.ppf((1 + LEVEL) / 2, found.columns.shape[0] - len(z))) * error
    bound = [name for name, at, low in zip(sought.names, z, sought.low, strict=True) if at - low < _AT_BOUND]
    return Fit(
        name=system.name, digest=system.digest, names=sought.names, count=sought.count, values=values, standard_error=error,
        confidence=np.column_stack([values - reach, values + reach]), correlation=correlation, singular=np.asarray(seen.singular),
        p=sought.parameters(z), x0=sought.state(z), columns=data.columns, t=data.t, measured=data.values, fitted=found.predicted,
        noise=found.noise, method=made.flow, iterations=found.iterations, seconds=time.perf_counter() - began,
        at_bound=tuple(bound),
    )  # fmt: skip


def told(made: Model, z: Vector) -> Directions:
    """What the data cannot tell apart at a point, on the horizon on which that is least.

    What no data of the kind can tell, no part of them tells. A chaotic motion that is followed for long from a wrong start grows one change so far
    beyond all others that rounding hides these; a short part of it does not.
    """
    rows, found = len(made.data.t), []
    for share in _SHARES:
        columns = weighted(made, z, rows=max(rows // share, min(rows, 4 * len(z))))
        found.append(directions(columns, made.noise))
        if not len(found[-1].blind):
            break
    return min(found, key=lambda directions: len(directions.blind))


def errors(columns: Vector) -> tuple[Vector, Vector]:
    """Standard errors (k,) and correlations (k, k) from columns (m, k) over their noise: (J^T J)^-1 by singular values."""
    lengths = np.linalg.norm(columns, axis=0)
    _, singular, rows = np.linalg.svd(columns / lengths, full_matrices=False)
    deviation, correlation = spread(rows.T / singular)
    return deviation / lengths, correlation


def spread(root: Vector) -> tuple[Vector, Vector]:
    """Standard errors (k,) and correlations (k, k) of a covariance L L^T from its root L (k, k)."""
    covariance = root @ root.T
    deviation = np.sqrt(np.diag(covariance))
    return deviation, covariance / np.outer(deviation, deviation)


def _start(system: System, data: Measurement) -> tuple[Vector, Vector]:
    """The state at the first row, and the sizes of its entries: a parabola through the first rows where rates were not measured."""
    names = (*system.q_names, *system.v_names)
    t, first, sizes = np.asarray(data.t), np.zeros(system.nx), np.ones(system.nx)
    width = min(max(len(t) // 50, 5), 50, len(t) - 1)
    for name, column in zip(data.columns, np.asarray(data.values).T, strict=True):
        at = names.index(name)
        span = float(t[width] - t[0])
        parabola = np.polynomial.polynomial.polyfit((t[: width + 1] - t[0]) / span, column[: width + 1], 2)
        first[at], sizes[at] = parabola[0], max(float(np.std(column)), 1e-3)
        rate = at + system.nq
        if at < system.nq and names[rate] not in data.columns:
            first[rate] = parabola[1] / span
            sizes[rate] = max(float(np.std((column[width:] - column[:-width]) / (t[width:] - t[:-width]))), 1e-3)
    return first, sizes
