"""Brake orbits off any plane, followed from where orbits in a plane lose it at their rests."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np

from phichain.continuation import (
    Branch,
    BranchPoint,
    Fold,
    Level,
    Point,
    Problem,
    Quantity,
    Special,
    TestFunction,
    follow,
    start_on,
)
from phichain.continuation.events import signed
from phichain.errors import ArrayError, UnsupportedError
from phichain.orbits import shooting
from phichain.orbits.in_plane import METHOD as IN_PLANE
from phichain.orbits.in_plane import PLANE_LOSS
from phichain.orbits.in_space.problem import (
    METHOD,
    SpaceMap,
    closing_of,
    kept_of,
    pairs_of,
    space_problem,
    state_at_rest,
)
from phichain.orbits.run import Run
from phichain.orbits.symmetry import BRANCH_POINT, SAID, discriminant, ended_by, genuine, too_unstable
from phichain.orbits.targets import Target
from phichain.orbits.whirling.starts import demand_whirling, given_family
from phichain.records import Held
from phichain.system import Parameters, System, Vector

settings = shooting.settings
START = shooting.START
PLANE: Final = "in a plane"
_SINGULAR: Final = 1e-6
_FLAT: Final = 1e-4
"""Angles, rad, out of the plane below which an orbit lies in it: orbits where families end are located to 1e-8."""
_OWN: Final = {
    "brake loss": ("the rest: orbits beside it never stand still", "orbits that come back turned, which no method here follows from there"),
    "odd loss": ("the rest, and the hanging chain's half turn", "orbits that are odd about where the chain hangs straight, which no method here follows"),
    "unequal brakes": ("the hanging chain's half turn", "brake orbits between two unequal rests, which no method here follows"),
    PLANE: ("nothing: the orbits come to lie in a plane", 'orbits "in a plane"'),
    BRANCH_POINT: ("no symmetry of this family: another one crosses", "brake orbits in space"),
}


@dataclass(frozen=True, eq=False)
class Rest(Held):
    """Where a family begins.

    Attributes:
        z: Unknowns there (2 N + 1,).
        shape: How it leaves (2 N + 1,), the largest change of an angle 1.
        kept: The link, from 0, whose rest stays in the plane.
    """

    z: Vector
    shape: Vector
    kept: int


def from_plane(system: System, start: Any, p: Parameters | None = None) -> tuple[Rest, ...]:
    """The family that opens where orbits in a plane lose it at their rests.

    Args:
        system: A spatial chain on a fixed base.
        start: (Branch, event) of orbits in a plane, or "FILE.json:event=K".
        p: Runtime parameters.

    Raises:
        UnsupportedError: The chain is none, or the event opens orbits that turn instead.
        ArrayError: It is no such event.
    """
    demand_whirling(system, METHOD)
    branch, event = given_family(start)
    if branch.digest != system.digest:
        raise ArrayError("start", branch.digest, f"is the digest of that branch's scene, and {system.digest!r} is wanted here", "use its scene")
    if branch.method != IN_PLANE or not isinstance(event, Special) or event.kind != PLANE_LOSS:
        raise ArrayError("start", getattr(event, "kind", event), "is nothing that brake orbits in space begin at", f'give (Branch, event), a "{PLANE_LOSS}" of orbits in a plane')
    links, angles = system.links, event.z[:-1]
    kept = int(np.argmax(np.abs(angles)))
    z = np.concatenate([angles, np.zeros(links), event.z[-1:]])
    problem = space_problem(system, p, omega=float(event.z[-1]), kept=kept)
    # Motions out of the plane, and what unfolds.
    columns = list(range(links, 2 * links))
    _, sizes, rows = np.linalg.svd(problem.at(z / problem.sizes).jacobian[:, columns])
    if sizes[-1] > _SINGULAR * sizes[0]:
        raise UnsupportedError(
            "start", PLANE_LOSS, "opens no orbits that stand still off the plane: orbits that turn begin there", 'use method = "whirling"'
        )
    shape = np.zeros(len(z))
    shape[columns] = rows[-1]
    return (Rest(z, shape / np.max(np.abs(shape)), kept),)


def trace_in_space(system: System, rests: tuple[Rest, ...], mode: int, target: Target | None, run: Run) -> Branch:
    """Follow the brake orbits that leave a plane.

    Args:
        system: A spatial chain on a fixed base.
        rests: Where they begin, `from_plane`.
        mode: 1, there is one family.
        target: Where to end; theta_K is the angle of link K in the plane where it starts, amplitude the largest of them.
        run: How it is followed.

    Raises:
        ConvergenceError: Newton did not reach the family.
    """
    if run.earlier is None:
        begun = rests[mode - 1]
        kept, omega = begun.kept, float(begun.z[-1])
    else:
        kept, omega = kept_of(run.earlier.closing), float(run.earlier.scale[-1])
    problem = space_problem(system, run.p, omega=omega, kept=kept)
    tests = [*events_of(system, problem, kept), *_ends(system, problem, target, omega)]
    first = run.earlier if run.earlier is not None else start_on(
        problem, begun.z + run.amplitude_start * begun.shape, begun.shape, run.engine, fixed=True
    )  # fmt: skip
    branch = follow(problem, first, run.engine, tests, f"{system.name}, {METHOD}", through=run.through, progress=run.progress)
    events, last = ended_by(branch, (BRANCH_POINT,))
    events += [replace(last, kind=PLANE)] if last else []
    states = np.array([_state(system, z, kept) for z in branch.points])
    reason = f"ended {PLANE}" if last else branch.reason
    told = tuple(_told(system, event, kept) for event in events if genuine(event))
    return replace(branch, events=told, reason=reason, states=states, closing=closing_of(kept))


def events_of(system: System, problem: Problem, kept: int) -> list[TestFunction]:
    """The test functions of such a family."""
    links = system.links

    def of(point: Point) -> SpaceMap:
        found: SpaceMap = point.extra.found
        return found

    def lost(point: Point) -> float:
        maps = of(point)
        return signed(np.block([[maps.d, maps.rate[:, None]], [maps.force[None, :], np.zeros((1, 1))]]))

    def slope(point: Point) -> float:
        near = point.z(problem), 1e-5 * point.slope(problem)
        assert problem.energy is not None
        return (problem.energy(near[0] + near[1]) - problem.energy(near[0] - near[1])) / 2e-5

    return [
        Fold(name="fold omega"),
        *(Fold(k, f"fold amplitude {k + 1}") for k in range(links)),
        Quantity(slope, "energy extremum"),
        BranchPoint(BRANCH_POINT, ends=lambda problem, point: float(np.max(np.abs(pairs_of(point.z(problem), kept)[1::2]))) < _FLAT),
        Quantity(lost, "brake loss"),
        Quantity(lambda point: signed(of(point).b), "odd loss"),
        Quantity(lambda point: signed(of(point).c), "unequal brakes"),
        Quantity(discriminant, "krein", in_pairs=True),
        too_unstable(),
    ]


def _ends(system: System, problem: Problem, target: Target | None, omega: float) -> list[TestFunction]:
    links = system.links

    def largest(z: Vector) -> float:
        return float(np.max(np.abs(z[: 2 * links - 1])))

    own: list[TestFunction] = []
    if target is not None and target.what == "amplitude":
        own = [Level(lambda z: float(np.max(np.abs(z[:links]))), target.value, str(target))]
    elif target is not None:
        own = [target.level(system, problem, 0)]
    return [*own, Level(largest, np.pi, "amplitude pi"), Level(lambda z: float(z[-1]), 1e-3 * omega, "omega near zero")]


def _state(system: System, z: Vector, kept: int) -> Vector:
    return np.append(state_at_rest(system.links, pairs_of(z, kept)), np.zeros(system.nv))


def _told(system: System, event: Special, kept: int) -> Special:
    word = event.kind.rstrip("0123456789 ")
    breaks, continues = _OWN.get(word) or SAID.get(word, ("", ""))
    return replace(event, breaks=breaks, continues=continues, state=_state(system, event.z, kept))
