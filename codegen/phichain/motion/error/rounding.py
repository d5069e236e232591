"""What rounding makes of a run of the Taylor flow at round-off, beside which nothing is more accurate.

The flow's sums are compensated, so that a step's error is round-off of what the state moves by in it. Neighbours that are pushed by
as much, amplified, show what these errors add up to and grow to.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from phichain.motion.error.measure import LOST, Measure
from phichain.motion.error.neighbours import STRIDE, errors_beside
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
#: The same run at this many times the tolerance rounds otherwise at every step; an error is not more than so many times the difference.
OTHERWISE: Final = 4.0
#: Errors above this part of what matters are looked at twice.
CLOSE: Final = 1e-3
ALIKE: Final = 10.0
_LEAST: Final = 1e-8


def rounded(problem: Problem, path: Path, measure: Measure, most: float) -> Vector:
    """Estimated errors (m,) along a path of the Taylor flow; infinity once they are as large as the motion.

    Beside a separatrix neighbours part that the run itself does not see, so that errors above `most` are held against the same run
    with other steps as well.
    """
    local = _local(problem, path, measure)
    error = errors_beside(problem, path, local, measure, float(np.max(measure(path.x))), CLOSE * most)
    return error if np.max(error) <= most else held_against_other_steps(problem, path, measure, error, float(np.max(local)))


def held_against_other_steps(problem: Problem, path: Path, measure: Measure, error: Vector, floor: float) -> Vector:
    """Errors (m,), no more than so many times the difference to the same run with other steps, and the floor."""
    # Where two runs with other steps are lost as well, as most are, nothing is to be seen beyond.
    lost = np.flatnonzero(error > LOST)
    first = int(lost[0]) if lost.size else len(error) - 1
    at, state = 0, path.x[0]
    for stop in (first, len(error) - 1):
        if stop == at or error[at] > LOST:
            break
        other = flown(problem, path.t[at : stop + 1], state, OTHERWISE * problem.tol, 2 * path.steps + STRIDE)
        if len(other) < stop - at:
            break
        new = slice(at + 1, stop + 1)
        error[new] = np.minimum(error[new], ALIKE * measure(other - path.x[new]) + floor)
        at, state = stop, other[-1]
    return error


def _local(problem: Problem, path: Path, measure: Measure) -> Vector:
    """What the steps since the time before have added, (m,)."""
    of_moved, of_tolerance = LOCAL
    gaps = np.abs(np.diff(path.t))
    steps = np.maximum(path.steps * gaps / np.sum(gaps), _LEAST)
    # Between outputs that many steps lie apart the state has moved by more than they differ: by its rates at least.
    nq = problem.system.nq
    rates = np.max(np.abs(path.x[1:, nq:]), axis=1) * np.max(measure.weights[:nq])
    moved = np.maximum(measure(np.diff(path.x, axis=0)), np.where(steps > 2, rates * gaps, 0.0))
    of_rounding = of_moved * float(np.finfo(float).eps) * np.maximum(moved / steps, _LEAST)
    of_one = of_rounding + (of_tolerance * problem.tol if problem.tol > _EXACT else 0.0)
    return np.append(0.0, of_one * np.sqrt(steps))
