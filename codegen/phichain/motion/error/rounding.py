"""What rounding makes of a run of the Taylor flow at round-off: local errors of every step, carried by the tangent flow.

The flow's sums are compensated, so that a step's error r_k is round-off of what the state moves by in it. With Phi the tangent flow
independent errors add up to

    e(t)^2 = sum_k r_k^2 |Phi(t, t_k)|^2

over the steps before t. Of Phi only the growth G(t) = |Phi(t, t_0) d| of one direction is known, which gives two estimates of the
sum, and the larger is taken. Where the motion is chaotic every direction turns into one that grows, |Phi(t, t_k)| = G(t) / G(t_k),
also where d itself was slow to grow. Where it is regular errors grow with the time since they were made, |Phi(t, t_k)| =
G(t - t_k) up to the phase of the motion, which G(t) relative to its largest so far says.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from phichain.motion.error.growth import STRIDE, growth
from phichain.motion.error.measure import Measure
from phichain.motion.error.second import flown
from phichain.motion.path import Path
from phichain.motion.problem import Problem
from phichain.system import Vector

#: Up to this tolerance rounding is what a Taylor run's errors come from (the flow aims 256 times below it).
FINEST: Final = 2.0**-40
#: At tolerances up to this the flow aims below round-off.
_EXACT: Final = 2.0**-46
#: Local error of a step over what it moves by, in units of round-off; and of the motion, in units of the tolerance.
LOCAL: Final = (1.0, 2.0**-9)
_LEAST: Final = 1e-100
_BINS: Final = 256
#: The same run at this many times the tolerance rounds otherwise at every step; an error is not more than so many times the difference.
OTHERWISE: Final = 4.0
ALIKE: Final = 10.0


def rounded(problem: Problem, path: Path, measure: Measure, most: float) -> Vector:
    """Estimated errors (m,) along a path of the Taylor flow; not above what the motion covers.

    Beside a separatrix neighbours part that the run itself does not see, so that errors above `most` are held against the same run
    with other steps as well.
    """
    local = _local(problem, path, measure)
    carried = growth(problem, path, measure, measure.covered / max(float(np.max(local)), _LEAST))
    error = np.full(len(path.t), measure.covered)
    known = np.isfinite(carried)
    error[known] = np.minimum(_sum(path.t[known], carried[known], local[known]), measure.covered)
    if np.max(error) <= most:
        return error
    other = flown(problem, path.t, path.x[0], OTHERWISE * problem.tol, 2 * path.steps + STRIDE)
    if len(other) == len(path.t) - 1:
        error[1:] = np.minimum(error[1:], ALIKE * measure(other - path.x[1:]) + np.max(local))
    return error


def _local(problem: Problem, path: Path, measure: Measure) -> Vector:
    """What the steps since the time before have added, (m,)."""
    of_moved, of_tolerance = LOCAL
    gaps = np.abs(np.diff(path.t))
    steps = np.maximum(path.steps * gaps / np.sum(gaps), _LEAST)
    # Between outputs that many steps lie apart the state has moved by more than they differ: by its rates at least.
    rates = np.max(np.abs(path.x[1:, problem.system.nq :]) * measure.weights[: problem.system.nq].max(), axis=1)
    moved = np.maximum(measure(np.diff(path.x, axis=0)), np.where(steps > 2, rates * gaps, 0.0))
    of_one = of_moved * float(np.finfo(float).eps) * moved / steps + (of_tolerance * problem.tol if problem.tol > _EXACT else 0.0)
    return np.append(0.0, of_one * np.sqrt(steps))


def _sum(t: Vector, carried: Vector, local: Vector) -> Vector:
    """Root of sum_k r_k^2 |Phi(t, t_k)|^2 at each time, from the growth and what was added since the time before."""
    g = np.maximum(carried, _LEAST)
    chaotic = g**2 * np.cumsum((local / g) ** 2)
    # sum_k r_k^2 G(t - t_k)^2 in bins of time: what counts is how it grows.
    past = np.abs(t - t[0])
    bins = np.minimum((_BINS * past / past[-1]).astype(int), _BINS - 1) if len(t) > 1 else np.zeros(1, int)
    spread = np.interp((np.arange(_BINS) + 0.5) * past[-1] / _BINS, past, g)
    regular = np.convolve(np.bincount(bins, local**2, _BINS), spread**2)[bins] * (g / np.maximum.accumulate(g)) ** 2
    total: Vector = np.sqrt(np.maximum(chaotic, regular))
    return total
