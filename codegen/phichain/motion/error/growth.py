"""How errors grow along a path: a neighbour of it, flown loosely beside it and brought near again whenever it strays.

The difference of two motions that start close together is carried by the tangent flow as long as it is small. What it grows by
from one return to the next multiplies up to |Phi(t, t_0) d|, over any span (Benettin et al., Meccanica 15, 1980). The neighbour
has to be no more accurate than the distance it is kept at, which is far above round-off: its orders are half those of the run that
is judged, and it costs a quarter.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from phichain.motion.error.measure import Measure
from phichain.motion.error.second import flown
from phichain.motion.manifold import project_state
from phichain.motion.path import Path
from phichain.motion.problem import Problem
from phichain.records import Held
from phichain.system import Vector, pack

#: How far from the path a neighbour starts, and how far from it is too far for the tangent, of the motion.
NEAR: Final = 1e-5
FAR: Final = 1e-2
#: The neighbour's tolerance at most, and times the steps of the path: its own errors add up and must stay below NEAR.
LOOSE: Final = (1e-6, 1e-4)
#: Steps of the path for which a neighbour flies at first without a look.
STRIDE: Final = 64
_BUDGET: Final = 1_000_000


@dataclass(frozen=True, eq=False)
class _Way(Held):
    """Part of a path and what flies beside it.

    Attributes:
        problem: What was integrated.
        t: Times (m,).
        x: States (m, nx).
        measure: How large a difference is.
        tol: Tolerance of the neighbour.
        enough: Growth beyond which nobody looks.
    """

    problem: Problem
    t: Vector
    x: Vector
    measure: Measure
    tol: float
    enough: float

    def near(self, at: int, direction: Vector) -> Vector:
        """The state at NEAR from the path's, in a direction of size 1."""
        system, moved = self.problem.system, self.x[at] + NEAR * direction
        return moved if system.is_planar else pack(*project_state(system, moved[: system.nq], moved[system.nq :]))


def growth(problem: Problem, path: Path, measure: Measure, enough: float) -> Vector:
    """What an error at the start of a path has grown by at its times, (m,); infinity after it has grown by `enough`."""
    most, share = LOOSE
    way = _Way(problem, path.t, path.x, measure, min(most, share / max(path.steps, 1)), enough)
    direction = np.cos(1.0 + 2.0 * np.arange(path.x.shape[1])) / measure.weights  # of no symmetry
    stride = max(1, STRIDE * (len(path.t) - 1) // max(path.steps, 1))
    return _along(way, direction, stride, _closely)[0]


Within = Callable[[_Way, int, Vector, Vector], tuple[float, Vector]]


def _along(way: _Way, direction: Vector, stride: int, within: Within) -> tuple[Vector, Vector]:
    """Growth at the times of a way, and the direction in which the error then lies.

    Args:
        way: The way.
        direction: Where the error lies at its start, of size 1.
        stride: Outputs to the first look.
        within: What to do with a gap between outputs in which the neighbour strays: growth over it, and the direction then.
    """
    last, found = len(way.t) - 1, np.full(len(way.t), np.inf)
    found[0], at, level, size = 1.0, 0, 1.0, 0.0
    beside: Vector | None = None
    while at < last and level <= way.enough:
        is_new = beside is None
        if beside is None:
            beside = way.near(at, direction)
            size = float(way.measure(beside - way.x[at]))
        stop = min(at + stride, last)
        states = flown(way.problem, way.t[at : stop + 1], beside, way.tol, _BUDGET)
        if not len(states):
            break
        off = states - way.x[at + 1 : at + 1 + len(states)]
        sizes = way.measure(off)
        many = int(np.argmin(np.append(sizes <= FAR, False)))
        if many:
            found[at + 1 : at + 1 + many] = level / size * sizes[:many]
            size, direction = float(sizes[many - 1]), off[many - 1] / sizes[many - 1]
            at += many
        elif is_new:
            more, direction = within(way, at, direction, off[0])
            at += 1
            found[at] = level * more
        level = float(found[at])
        beside = states[-1] if many and at == stop and size > NEAR / 10 else None
        stride = 2 * stride if at == stop else max(1, many)
    return found, direction


def _closely(way: _Way, at: int, direction: Vector, off: Vector) -> tuple[float, Vector]:
    """Growth over one gap, along the steps that the run took there."""
    problem, nq, x = way.problem, way.problem.system.nq, way.x[at]
    given = {} if problem.held is None else {"u": problem.held}
    span = float(way.t[at]), float(way.t[at + 1])
    steps = problem.system.propagate(x[:nq], x[nq:], *span, problem.tol, own=True, **given, **problem.system.parameters(problem.p))
    t, states = np.append(span[0], steps.t_at), np.vstack([x, pack(steps.q_at, steps.v_at)])
    found, direction = _along(replace(way, t=t, x=states), direction, STRIDE, _at_once)
    return float(found[-1]), direction


def _at_once(way: _Way, at: int, direction: Vector, off: Vector) -> tuple[float, Vector]:
    """Growth over one step, the tangent's or not."""
    size = float(way.measure(off))
    return size / NEAR, off / size
