"""Whirling families followed: from small motions beside conical orbits, and from orbits in a plane."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from phichain.continuation import (
    Branch,
    BranchPoint,
    Engine,
    Fold,
    Level,
    Options,
    Point,
    Problem,
    Quantity,
    Special,
    TestFunction,
    follow,
    predictors,
    start_on,
)
from phichain.continuation.events import signed
from phichain.orbits.run import Run
from phichain.orbits.symmetry import BRANCH_POINT, discriminant, ended_by, too_unstable
from phichain.orbits.targets import Target
from phichain.orbits.whirling.fixed import inertia_of
from phichain.orbits.whirling.problem import WhirlMap, held_value, momentum, state_of_whirl, whirling_problem
from phichain.orbits.whirling.starts import METHOD, Whirl, sized
from phichain.system import System

START: Final = 1e-2
"""Largest angle, rad, by which a family's first point is off where it begins."""
CONICAL: Final = "back at a conical orbit"
PLANE: Final = "in a plane"
PERIOD_DOUBLING: Final = "period doubling"
TURNS_BACK: Final = "no momentum"
_SLOW: Final = 1e-3
_NONE: Final = 1e-4
"""Angles, rad, rates in frequencies and momenta in their size below which there is none: orbits where families end are located to 1e-8."""
_SAID: Final = {
    "fold omega": ("no symmetry: the period turns", "this family"),
    "fold turn": ("no symmetry: the angle by which orbits come back turned has an extremum", "this family"),
    "energy extremum": ("no symmetry: the energy turns", "this family"),
    "momentum extremum": ("no symmetry: the angular momentum turns", "this family"),
    "reversal loss": ("the mirror image that runs backwards", "orbits without it, method 'unmirrored'"),
    PERIOD_DOUBLING: ("the period: orbits beside it come back, turned, after two", "whirling orbits of twice the period, which no method here follows"),
    "krein": ("no symmetry: two pairs of multipliers leave the unit circle", "this family"),
    TURNS_BACK: ("no symmetry: beyond it the chain turns the other way", "this family"),
    BRANCH_POINT: ("no symmetry of this family: another one crosses", "whirling orbits"),
    PLANE: ("nothing: the orbits come to lie in a plane", 'orbits "in a plane"'),
    CONICAL: ("nothing: the orbits come to a relative equilibrium", "conical orbits"),
}


def settings(options: Options | None) -> Engine:
    """Predictor, corrector and options of a whirling family."""
    return Engine(predictors.cubic, options=options or Options(step=0.01, step_max=0.1, max_points=2000, tol=1e-9))


def trace_whirling(
    system: System,
    whirls: Sequence[Whirl],
    mode: int,
    target: Target | None,
    run: Run,
    *,
    hold: str = "momentum",
) -> Branch:
    """Follow one family of orbits that come back turned, one quantity held.

    Args:
        system: A spatial chain on a fixed base.
        whirls: Where families begin, `whirls_of`.
        mode: Which of them, from 1.
        target: Where to end: theta_K (of the start), amplitude (the largest), omega or energy.
        hold: "momentum" about the vertical, "energy", or "turn", the angle by which orbits come back turned; as it is where the family begins.
        run: How it is followed.

    Returns:
        The Branch of (theta, rates, turn, omega) with states, energy, momentum and kappa of one period.

    Raises:
        ConvergenceError: Newton did not reach the family.
        ArrayError: Nothing of that name can be held.
    """
    inertia = inertia_of(system, run.p)
    if run.earlier is None:
        begun = whirls[mode - 1]
        origin, omega, where = begun.z, float(begun.z[-1]), begun.where
    else:
        origin, omega, hold, where = run.earlier.points[0], float(run.earlier.scale[-1]), run.earlier.closing.removesuffix(" held"), "gone on with"
    value = held_value(system, run.p, hold, origin)
    problem = whirling_problem(system, run.p, held=hold, value=value, omega=omega)
    tests = _tests(system, problem, target, hold)
    first = run.earlier if run.earlier is not None else _first(problem, begun, run.amplitude_start, run.engine)
    name = f"{system.name}, whirling, {hold} held, {where}" if run.earlier is None else run.earlier.name
    branch = follow(problem, first, run.engine, tests, name, through=run.through, progress=run.progress)
    events = _told(problem, branch)
    reason = f"ended {events[-1].kind}" if events and events[-1].kind in (CONICAL, PLANE) else branch.reason
    states = np.array([state_of_whirl(z) for z in branch.points])
    carried = np.array([momentum(inertia, x) for x in states])
    return replace(
        branch, events=events, reason=reason, momentum=carried, states=states, closing=f"{hold} held", scene=system.name, digest=system.digest, method=METHOD,
        mode=mode, p=system.values(run.p),
    )  # fmt: skip


def _first(problem: Problem, begun: Whirl, amplitude: float, engine: Engine) -> Point:
    shape = begun.shape
    if not np.any(shape):
        rows = np.linalg.svd(problem.at(begun.z / problem.sizes).jacobian)[2]
        shape = rows[-1] * problem.sizes
        shape = shape / np.max(np.abs(sized(shape, begun.z[-1])))
    # Newton keeps the largest share of the shape as it is: the family's own trivial solutions lie across it.
    normal = shape / problem.sizes**2
    return start_on(problem, begun.z + amplitude * shape, normal * problem.sizes, engine, fixed=True)


def events_of(system: System, problem: Problem, hold: str) -> list[TestFunction]:
    """The test functions of a family along which something is held."""
    links = system.links

    def of(point: Point) -> WhirlMap:
        found: WhirlMap = point.extra.found
        return found

    def lost(point: Point) -> float:
        maps = of(point)
        return signed(np.block([[maps.b, maps.ended], [maps.begun.T, np.zeros((2, 2))]]))

    def carried(point: Point) -> float:
        return of(point).momentum

    def turns(column: int) -> TestFunction:
        return Quantity(
            lambda point: float(of(point).slopes[:, column] @ point.slope(problem)[: 2 * links]), ("energy extremum", "momentum extremum")[column]
        )

    several: list[TestFunction] = [
        Quantity(lost, "reversal loss"),
        Quantity(lambda point: signed(of(point).a), PERIOD_DOUBLING),
        Quantity(lambda point: signed(of(point).d), PERIOD_DOUBLING),
        too_unstable(),
        Quantity(discriminant, "krein", in_pairs=True),
    ]
    return [
        Fold(name="fold omega"),
        *([Fold(2 * links, "fold turn")] if hold != "turn" else []),
        *([turns(0)] if hold != "energy" else []),
        *([turns(1)] if hold != "momentum" else []),
        BranchPoint(BRANCH_POINT, ends=lambda problem, point: _end_of(problem, point) != ""),
        *([Quantity(carried, TURNS_BACK, ends=lambda problem, point: _end_of(problem, point) != "")] if hold != "momentum" else []),
        *(several if links > 1 else []),
    ]


def _tests(system: System, problem: Problem, target: Target | None, hold: str) -> list[TestFunction]:
    return [
        *events_of(system, problem, hold),
        *([_level(system, target, problem, system.links)] if target is not None else []),
        Level(lambda z: float(z[-1]), _SLOW * float(problem.sizes[-1]), "omega near zero"),
    ]


def _end_of(problem: Problem, point: Point) -> str:
    """Where a family ends at an orbit that is one of fewer dimensions: at a conical one, or at one in a plane; empty where it goes on."""
    z, found = point.z(problem), point.extra.found
    if found.spread < _NONE:
        return CONICAL
    own, links = np.abs(sized(z, float(z[-1]))), len(z) // 2 - 1
    return PLANE if min(np.max(own[:links]), np.max(own[links:])) < _NONE and abs(found.momentum) < _NONE else ""


def _level(system: System, target: Target, problem: Problem, links: int) -> TestFunction:
    """Where the family is to end: an angle of the start, the largest, omega or energy."""
    if target.what != "amplitude":
        return target.level(system, problem, 0)
    return Level(lambda z: float(np.max(np.abs(z[:links]))), target.value, str(target))


def _told(problem: Problem, branch: Branch) -> tuple[Special, ...]:
    """The events under their names, and nothing that only seems to turn where the family ends."""
    events, last = ended_by(branch, (BRANCH_POINT, TURNS_BACK))
    if last:
        y = last.z / problem.sizes
        evaluation = problem.at(y)
        at = Point(y, branch.tangent[-1] / problem.sizes, last.arclength, evaluation.jacobian, 0.0, 0, (), evaluation.extra)
        events.append(replace(last, kind=_end_of(problem, at)))
    return tuple(_said(event) for event in events)


def _said(event: Special) -> Special:
    breaks, continues = _SAID.get(event.kind, ("", ""))
    return replace(event, breaks=breaks, continues=continues, state=state_of_whirl(event.z))
