"""How the errors of every step add up and grow along a path: neighbours of it that are pushed as its own errors push it, only harder.

A neighbour flies beside the path, loosely. After every stride it is pushed in another direction by what the steps' local errors add
up to, times an amplification that keeps it visible: near enough for the tangent flow to carry the difference, far enough for the
neighbour's own errors not to matter. Whenever it strays it is brought back along the line to the path and the amplification falls
with it (as Benettin et al., Meccanica 15, 1980, do for exponents). The difference over the amplification is an error as the path
may have it, of any age and direction, and however large: a neighbour's orders are lower than those of the run that is judged and
its steps are longer, so that it costs a fifth of it.
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

#: How far from the path a neighbour is put, and how far from it is too far for the tangent, of the motion.
NEAR: Final = 1e-5
FAR: Final = 1e-2
#: The neighbour's tolerance at most, and times the steps of the path: its own errors add up and must stay below NEAR.
LOOSE: Final = (1e-6, 1e-4)
#: Steps of the path to the first push; where errors grow by less than so much from push to push, they come half as often.
STRIDE: Final = 128
CALM: Final = 4.0
#: Directions that differ by less have turned into one.
ALIGNED: Final = 0.03
#: A push by less than this part of the difference is none.
FELT: Final = 1e-3
_BUDGET: Final = 1_000_000
_HOPELESS: Final = 1e12
_NONE: Final = 1e-300


@dataclass(frozen=True, eq=False)
class Neighbour(Held):
    """What one neighbour says of the errors along a path.

    Attributes:
        error: How large they are, (m,); infinity once they are more than enough.
        direction: Where they lie, of size 1, (m, nx); NaN where it is not known.
    """

    error: Vector
    direction: Vector


@dataclass(frozen=True, eq=False)
class _Way(Held):
    """Part of a path, what flies beside it, and how that is pushed.

    Attributes:
        problem: What was integrated.
        t: Times (m,).
        x: States (m, nx).
        local: What the steps since the time before have added, (m,).
        measure: How large a difference is.
        tol: Tolerance of the neighbour.
        enough: Errors beyond which nobody looks.
        phase: Of the pushes' directions.
        known: Another neighbour, into whose direction this one may turn.
    """

    problem: Problem
    t: Vector
    x: Vector
    local: Vector
    measure: Measure
    tol: float
    enough: float
    phase: float
    known: Neighbour | None = None

    def beside(self, at: int, off: Vector) -> Vector:
        """The state that is off the path's by so much."""
        system, moved = self.problem.system, self.x[at] + off
        return moved if system.is_planar else pack(*project_state(system, moved[: system.nq], moved[system.nq :]))

    def push(self, at: int) -> Vector:
        """A direction of size about 1 and no symmetry."""
        found: Vector = np.cos(self.phase + at + (2.0 + self.phase) * np.arange(self.x.shape[1])) / self.measure.weights
        return found

    def added(self, begin: int, end: int) -> float:
        """What the steps from one of the times to another have added."""
        return float(np.sqrt(np.sum(self.local[begin + 1 : end + 1] ** 2)))


def errors_beside(problem: Problem, path: Path, local: Vector, measure: Measure, enough: float, near: float) -> Vector:
    """Errors (m,) along a path whose steps add `local` ones.

    Where one neighbour's come near to what matters, by `near`, they are the larger of two neighbours', one of which may have been
    lucky; as soon as the two have turned into each other's direction one is enough.
    """
    most, share = LOOSE
    way = _Way(problem, path.t, path.x, local, measure, min(most, share / max(path.steps, 1)), enough, 1.0)
    stride = max(1, STRIDE * (len(path.t) - 1) // max(path.steps, 1))
    first_stride = min(stride, len(path.t) - 1)
    many = path.steps * abs((path.t[first_stride] - path.t[0]) / (path.t[-1] - path.t[0]))
    begin = way.added(0, first_stride) / max(1.0, many) ** 0.5  # one step's; those of the others come when it ends
    first = _along(way, NEAR * way.push(0), begin, stride, _closely)
    if np.max(first.error) < near:
        return first.error
    other = replace(way, phase=2.0, known=first)
    second = _along(other, NEAR * other.push(0), begin, stride, _closely)
    return np.maximum(first.error, second.error)


def _apart(way: _Way, one: Vector, other: Vector) -> float:
    """How far two directions are from one line: what grows most does so either way."""
    return float(min(way.measure(one - other), way.measure(one + other)))


Within = Callable[[_Way, int, Vector, Vector], tuple[Vector, float]]


def _along(way: _Way, off: Vector, begin: float, stride: int, within: Within) -> Neighbour:
    """A neighbour's errors along a way.

    Args:
        way: The way.
        off: How far off the path it begins.
        begin: The error that this stands for.
        stride: Outputs from push to push.
        within: What to do with a gap between outputs in which it strays: where it is after it, and of which error it strayed.
    """
    last = len(way.t) - 1
    error, direction = np.full(last + 1, np.inf), np.full(way.x.shape, np.nan)
    size, at = float(way.measure(off)), 0
    error[0], direction[0], scale = begin, off / size, begin / size
    while at < last and error[at] <= way.enough:
        stop, before = min(at + stride, last), at
        states = flown(way.problem, way.t[at : stop + 1], way.beside(at, off), way.tol, _BUDGET)
        if not len(states):
            break
        gaps = states - way.x[at + 1 : at + 1 + len(states)]
        sizes = way.measure(gaps)
        many = len(sizes) if sizes.max() <= FAR else int(np.argmax(~(sizes <= FAR)))
        if many:
            new = slice(at + 1, at + 1 + many)
            error[new] = scale * sizes[:many]
            np.divide(gaps[:many], sizes[:many, None], out=direction[new], where=sizes[:many, None] > 0)
            at, off, now = at + many, gaps[many - 1], float(sizes[many - 1])
        elif size <= 2 * NEAR:
            off, strayed = within(way, at, off, gaps[0])
            at, now = at + 1, float(way.measure(off))
            error[at], direction[at] = scale * strayed, off / now
            scale *= strayed / now
        else:
            now = size
        if way.known is not None and _apart(way, direction[at], way.known.direction[at]) < ALIGNED:
            error[at:] = way.known.error[at:] * (error[at] / way.known.error[at])
            break
        if not off.any():  # all errors of old are gone, as where a motion comes to rest: what the steps since then have added is left
            off = NEAR * way.push(at)
            size = float(way.measure(off))
            error[at] = max(way.added(before, at), _NONE)
            scale = error[at] / size
            continue
        grown, size = now / size, now
        stride = 2 * stride if at == stop and grown < CALM else max(1, min(stride, at - before))
        if at < stop or not NEAR / 10 < size < FAR / 10:
            off, scale, size = off * (NEAR / size), scale * (size / NEAR), NEAR
        pushed = way.added(before, at) / scale
        if pushed > FELT * size:
            off = off + pushed * way.push(at)
            size = float(way.measure(off))
    return Neighbour(error, direction)


def _closely(way: _Way, at: int, off: Vector, gap: Vector) -> tuple[Vector, float]:
    """Where a neighbour is after one gap, followed along the steps that the run took there."""
    problem, nq, x = way.problem, way.problem.system.nq, way.x[at]
    given = {} if problem.held is None else {"u": problem.held}
    span = float(way.t[at]), float(way.t[at + 1])
    steps = problem.system.propagate(x[:nq], x[nq:], *span, problem.tol, own=True, **given, **problem.system.parameters(problem.p))
    t, states = np.append(span[0], steps.t_at), np.vstack([x, pack(steps.q_at, steps.v_at)])
    inner = replace(way, t=t, x=states, local=np.zeros(len(t)), enough=_HOPELESS, known=None)
    found = _along(inner, off, float(way.measure(off)), STRIDE, _at_once)
    return NEAR * found.direction[-1], float(found.error[-1])


def _at_once(way: _Way, at: int, off: Vector, gap: Vector) -> tuple[Vector, float]:
    """The same over one step, tangent or not."""
    size = float(way.measure(gap))
    return gap * (NEAR / size), size
