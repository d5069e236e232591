"""What opens at an event: the problem that goes on beyond it, the orbit in its unknowns, and the direction in
which the new branch leaves.

The orbit at the event solves the problem of the kind with fewer symmetries too, and its Jacobian has two null
vectors there: the family's own tangent, and across it the perturbation that breaks the symmetry. At a cover
the shorter orbit is a regular one of its own family. Where a symmetry ends at a cover every perturbation of the
longer orbit closes to first order: a third null vector stands across, and which way in their plane leads on only higher
orders tell. It is tried all round.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from phichain.continuation import Branch, Engine, Point, Problem, Special, start_on
from phichain.continuation.events import signed
from phichain.continuation.met.deflation import deflated
from phichain.continuation.point import tangent_of
from phichain.errors import ConvergenceError
from phichain.orbits.closed.arrivals import shorter_orbit
from phichain.orbits.closed.kinds import KINDS, PERIOD_DOUBLING, PHASE_LOSS, problem_of, state_of, unknowns_of
from phichain.orbits.closed.symmetries import gains, recognised, taken_up
from phichain.orbits.quarter import EPS
from phichain.orbits.symmetry import BRANCH_POINT
from phichain.records import Held
from phichain.system import Parameters, System, Vector

_OFFSETS: Final = (0.02, 0.05, 0.01, 0.1, 0.005)
"""Distances, in scaled unknowns, at which a new branch is entered: beside the event itself it is as good as
singular."""
_SINGULAR: Final = 1e-5
"""Second smallest singular value, in the largest, below which a second null vector is believed."""
_ROUND: Final = 24
"""Directions that are tried in a plane of null vectors."""
_BESIDE: Final = 1e-4
"""Arclength over which a family's tangent is carried into other unknowns."""


@dataclass(frozen=True, eq=False)
class Opening(Held):
    """A way that leads on beyond an event.

    Attributes:
        kind: Kind of the orbits beyond.
        z: The orbit at the event in their unknowns.
        directions: Unit vectors in scaled unknowns (k, n + 1), one a branch.
        is_regular: Whether the event's orbit is a regular one of the new family (a cover), and not where it
            branches off.
        around: Further directions (m, n + 1), for a branch whose own direction leads to none; where null vectors leave the
            way open.
    """

    kind: str
    z: Vector
    directions: Vector
    is_regular: bool
    around: Vector | None = None


def opening_at(system: System, p: Parameters | None, branch: Branch, event: Special) -> Opening | str:
    """What opens at an event of a branch, or why nothing does, in words."""
    kind = branch.closing
    if event.kind.startswith("cover"):
        return regular_opening(system, p, *shorter_orbit(system, p, kind, event.z))
    if event.kind == PHASE_LOSS:
        return _going_on(system, p, branch)
    target, times = KINDS[kind].opens[event.kind]
    own = replace(problem_of(system, p, kind, event.z), scale=branch.scale)
    swapped = event.kind == PERIOD_DOUBLING and _is_doubled_beyond(kind, own, event.z)

    def converted(z: Vector) -> Vector:
        return _converted(system, p, kind, target, _from_its_end(kind, own, z) if swapped else z, times)

    z = converted(event.z)
    problem = problem_of(system, p, target, z)
    along = _BESIDE * _tangent(branch, event, own)
    carried = (converted(event.z + along) - converted(event.z - along)) / problem.sizes
    if not np.any(carried):
        return "its family does not move there"
    jacobian = problem.at(z / problem.sizes).jacobian
    _, sizes, rows = np.linalg.svd(jacobian)
    if not sizes[-1] < _SINGULAR * sizes[0]:
        return f"only one family passes there: the second null vector is missing by {sizes[-1] / sizes[0]:.1g}"
    across = _across(rows[np.count_nonzero(sizes >= _SINGULAR * sizes[0]) :], carried)
    both = event.kind == BRANCH_POINT
    return Opening(target, z, np.array([across[0], -across[0]] if both else across[:1]), False, across[1:])


def _across(null: Vector, own: Vector) -> Vector:
    """Directions within null vectors (rows) across a family's own: one where two are null, those all round a plane where three
    are, and both ways along each axis where more are."""
    own = null.T @ (null @ own)
    left = null.T @ null - np.outer(own, own) / (own @ own)
    axes = []
    for _ in null[1:]:
        axis = left[np.argmax(np.diag(left))]
        axes.append(axis / np.linalg.norm(axis))
        left = left - np.outer(axes[-1], axes[-1])
    if len(axes) != 2:
        return np.array([*axes, *(-axis for axis in axes)] if len(axes) > 1 else axes)
    angles = 2 * np.pi * np.arange(_ROUND) / _ROUND
    return np.outer(np.cos(angles), axes[0]) + np.outer(np.sin(angles), axes[1])


def regular_opening(system: System, p: Parameters | None, kind: str, z: Vector) -> Opening:
    """Both ways along the family of a regular orbit."""
    problem = problem_of(system, p, kind, z)
    tangent = tangent_of(problem.at(z / problem.sizes).jacobian, np.ones(len(z)))
    return Opening(kind, z, np.array([tangent, -tangent]), True)


def _going_on(system: System, p: Parameters | None, branch: Branch) -> Opening | str:
    """The same family taken up at the least of all its potentials, in the direction in which it was
    followed."""
    index = branch.regular - 1
    if index < 1:
        return "the branch begins there"
    kind, old = branch.closing, branch.points[index]
    q, v = taken_up(system, p, kind, *state_of(kind, old), float(old[-1]))
    z = unknowns_of(kind, q, v, float(old[-1]))
    ways = regular_opening(system, p, kind, z)
    problem = problem_of(system, p, kind, z)
    assert problem.energy is not None and branch.energy is not None
    wanted = np.array([old[-1] - branch.points[index - 1, -1], branch.energy[index] - branch.energy[index - 1]])
    ahead = z + _BESIDE * ways.directions[0] * problem.sizes
    found = np.array([ahead[-1] - z[-1], problem.energy(ahead) - problem.energy(z)])
    return replace(ways, directions=ways.directions[:1] if wanted @ found > 0 else ways.directions[1:])


def first_points(system: System, p: Parameters | None, opened: Opening, engine: Engine) -> tuple[Problem, list[Point | str]]:
    """The problem beyond an event, and the first point in every direction, or why there is none."""
    problem = problem_of(system, p, opened.kind, opened.z)
    if opened.is_regular:
        try:
            return problem, [start_on(problem, opened.z, way * problem.sizes, engine) for way in opened.directions]
        except ConvergenceError as failure:
            return problem, [str(failure)]
    return problem, [_entered(system, p, opened, problem, way, engine) for way in opened.directions]


def _entered(system: System, p: Parameters | None, opened: Opening, problem: Problem, way: Vector, engine: Engine) -> Point | str:
    """The first point of a branch in its direction, or in one of those around."""
    found = _entered_along(system, p, opened, problem, way, engine)
    for other in () if opened.around is None else opened.around:
        if not isinstance(found, str):
            break
        found = _entered_along(system, p, opened, problem, other, engine)
    return found


def _entered_along(system: System, p: Parameters | None, opened: Opening, problem: Problem, way: Vector, engine: Engine) -> Point | str:
    """The first point of a branch a little beyond where it opens, none of the family that it leaves."""
    known: list[Vector] = []
    for offset in _OFFSETS:
        guess = opened.z + offset * way * problem.sizes
        for target in (problem, deflated(problem, known)):
            try:
                point = start_on(target, guess, way * problem.sizes, engine, fixed=True)
                point = start_on(problem, point.z(problem), way * problem.sizes, engine, fixed=True)
            except ConvergenceError:
                continue
            z = point.z(problem)
            if not gains(opened.kind, recognised(system, p, *state_of(opened.kind, z), float(z[-1]))):
                return point
            known.append(point.y)
    return "Newton reached no orbit beside it that its own family has not"


def _converted(system: System, p: Parameters | None, kind: str, target: str, z: Vector, times: int) -> Vector:
    """An orbit of one kind in the unknowns of another with fewer symmetries, traversed a number of times."""
    q, v = state_of(kind, z)
    omega = float(z[-1])
    if kind == "quarter" and target in ("half", "odd"):
        found = system.propagate(q, v, 0.0, np.pi / (2 * omega), EPS, **system.parameters(p))
        # There it hangs straight but for rounding.
        q, v = np.zeros(system.nq), found.v
    elif kind == "unequal" and target == "whole":
        q, v = taken_up(system, p, target, q, v, omega)
    return unknowns_of(target, q, v, omega / times)


def _is_doubled_beyond(kind: str, problem: Problem, z: Vector) -> bool:
    """Whether the doubled orbit departs from the other end of half a period: where d of the half map is
    singular, and not a."""
    if kind == "whole":
        return False
    blocks = problem.evaluate(z).extra.found
    here, there = (blocks.a, blocks.d) if kind == "unequal" else (blocks.d, blocks.a)
    return abs(signed(here)) > abs(signed(there))


def _from_its_end(kind: str, problem: Problem, z: Vector) -> Vector:
    """The same orbit half a period later."""
    end = problem.evaluate(z).extra.found.end
    half = len(end) // 2
    return np.append(end[:half] if kind == "unequal" else end[half:], z[-1])


def _tangent(branch: Branch, event: Special, problem: Problem) -> Vector:
    """dz/ds of a family at one of its events."""
    chord = (branch.points[event.index + 1] - branch.points[event.index]) / branch.scale
    if event.kind == BRANCH_POINT:
        return chord / np.linalg.norm(chord) * branch.scale
    return tangent_of(problem.at(event.z / problem.sizes).jacobian, chord) * problem.sizes


def settled(problem: Problem, z: Vector, engine: Engine) -> Vector:
    """The orbit of that frequency, by Newton from one that is nearly right."""
    axis = np.zeros(len(z))
    axis[-1] = 1.0
    return start_on(problem, z, axis, engine, fixed=True).z(problem)

