"""Whether an orbit lies on a family that is known: by its frequency, its energy and its multipliers, which no
choice of phase and no mirror changes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Final

import numpy as np
from scipy.optimize import brentq

from phichain.continuation import Branch, Engine, Point, Problem
from phichain.continuation.met.between import curve
from phichain.continuation.problem import Multipliers
from phichain.continuation.record import point_of
from phichain.orbits.closed.kinds import problem_of
from phichain.system import Parameters, System, Vector

SAME: Final = 1e-7
"""Relative difference of frequency and energy below which two orbits are one."""
_ALIKE: Final = 1e-3
"""Difference of kappa, in sizes of 1 + |kappa|, that they may have then: kappa moves fast where families are
unstable."""
_BOW: Final = 0.5
"""How far from the chord between two points the curve between them may pass, in chords."""


def invariants(problem: Problem, z: Vector) -> Vector:
    """omega and energy (2,)."""
    assert problem.energy is not None
    return np.array([float(z[-1]), problem.energy(z)])


def is_same(a: Vector, b: Vector, share: float = SAME) -> bool:
    """Whether omega and energy agree."""
    return bool(np.all(np.abs(a - b) <= share * np.abs(b)))


def event_like(branches: Sequence[Branch], kind: str, target: Vector, problem: Problem) -> tuple[int, int] | None:
    """The branch and the event, of a kind of orbits, whose orbit has these invariants (2,)."""
    for k, branch in enumerate(branches):
        if branch.closing != kind:
            continue
        for at, event in enumerate(branch.events):
            if event.breaks and is_same(invariants(problem, event.z), target, 10 * SAME):
                return k, at
    return None


def branch_with(
    system: System, p: Parameters | None, branches: Sequence[Branch], kind: str, point: Point, problem: Problem, engine: Engine
) -> int | None:
    """The branch on which an orbit lies, its place in the sequence; None where it lies on none."""
    target, kappa = invariants(problem, point.z(problem)), point.multipliers
    for k, branch in enumerate(branches):
        if branch.closing == kind and _lies_on(system, p, branch, target, kappa, engine):
            return k
    return None


def _lies_on(system: System, p: Parameters | None, branch: Branch, target: Vector, kappa: Multipliers, engine: Engine) -> bool:
    assert branch.energy is not None
    known = np.column_stack([branch.points[:, -1], branch.energy]) / target
    problem = None
    for index in _near(known):
        problem = problem or replace(problem_of(system, p, branch.closing, branch.points[0]), scale=branch.scale)
        found = _closest(problem, branch, index, target, engine)
        if is_same(invariants(problem, found.z(problem)), target) and _alike(found.multipliers, kappa):
            return True
    return False


def _near(known: Vector) -> Iterator[int]:
    """Indices of the chords that pass near (1, 1)."""
    chords = np.diff(known, axis=0)
    lengths = np.linalg.norm(chords, axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        share = np.clip(np.nan_to_num(np.sum((1 - known[:-1]) * chords, axis=1) / lengths**2), 0, 1)
    off = np.linalg.norm(known[:-1] + share[:, None] * chords - 1, axis=1)
    yield from np.flatnonzero(off <= _BOW * lengths + SAME).tolist()


def _closest(problem: Problem, branch: Branch, index: int, target: Vector, engine: Engine) -> Point:
    """The point of a branch between two of its points that is across from the target, along their chord of
    invariants."""
    a, b = (point_of(problem, branch, k) for k in (index, index + 1))
    start, end = (invariants(problem, point.z(problem)) / target for point in (a, b))
    chord, between = end - start, curve(problem, a, b, engine)

    def ahead(s: float) -> float:
        return float((invariants(problem, between(s).z(problem)) / target - 1) @ chord)

    first, last = ahead(a.arclength), ahead(b.arclength)
    if first * last >= 0:
        return a if abs(first) < abs(last) else b
    return between(float(brentq(ahead, a.arclength, b.arclength, xtol=1e-13, rtol=1e-14)))


def _alike(a: Multipliers, b: Multipliers) -> bool:
    return len(a) == len(b) and bool(np.all(np.abs(a - b) <= _ALIKE * (1 + np.abs(b))))

