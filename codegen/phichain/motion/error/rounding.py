"""What rounding makes of a run of the Taylor flow at round-off: local errors of every step, carried by the tangent flow.

With r the local error of a step and Phi the tangent flow, independent errors add up to

    e(t)^2 = r^2 sum_k |Phi(t, t_k)|^2

over the steps before t. Of Phi only the growth G(t) = |Phi(t, t_0) d| of one direction is known, which gives two estimates of the
sum, and the larger is taken. Where the motion is chaotic every direction turns into one that grows, |Phi(t, t_k)| = G(t) / G(t_k),
also where d itself was slow to grow. Where it is regular errors grow with the time since they were made, |Phi(t, t_k)| =
G(t - t_k) up to the phase of the motion, so that the sum is that of G(t_k)^2, of which G(t) relative to its largest says the phase.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from phichain.motion.error.growth import growth
from phichain.motion.error.measure import Measure
from phichain.motion.path import Path
from phichain.motion.problem import Problem
from phichain.system import Vector

#: Up to this tolerance rounding is what a Taylor run's errors come from (the flow aims 256 times below it).
FINEST: Final = 2.0**-40
#: Local error of a step in units of round-off, and in units of the tolerance.
LOCAL: Final = (1.0, 2.0**-9)
_LEAST: Final = 1e-100


def rounded(problem: Problem, path: Path, measure: Measure) -> Vector:
    """Estimated errors (m,) along a path of the Taylor flow; not above what the motion covers."""
    of_round_off, of_tolerance = LOCAL
    local = of_round_off * float(np.finfo(float).eps) + of_tolerance * problem.tol
    carried = growth(problem, path, measure, measure.covered / local)
    error = np.full(len(path.t), measure.covered)
    known = np.isfinite(carried)
    steps = np.append(1.0, path.steps * np.abs(np.diff(path.t) / (path.t[-1] - path.t[0])))
    error[known] = np.minimum(local * _sum(carried[known], steps[known]), measure.covered)
    return error


def _sum(carried: Vector, steps: Vector) -> Vector:
    """Root of sum_k |Phi(t, t_k)|^2 at each time, from the growth and the steps taken since the time before."""
    g = np.maximum(carried, _LEAST)
    chaotic = g**2 * np.cumsum(steps / g**2)
    regular = (g / np.maximum.accumulate(g)) ** 2 * np.cumsum(steps * g**2)
    total: Vector = np.sqrt(np.maximum(chaotic, regular))
    return total
