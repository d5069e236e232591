"""vary: an orbit of a family, or an event of one, followed in a parameter of the chain."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, Final

import numpy as np

from phichain.continuation import (
    Branch,
    BranchPoint,
    Engine,
    Fold,
    Level,
    Options,
    Problem,
    Quantity,
    Special,
    TestFunction,
    follow,
    start_on,
)
from phichain.continuation.core import Progress
from phichain.continuation.events import signed
from phichain.errors import ArrayError, ConvergenceError
from phichain.orbits import shooting
from phichain.orbits.modes import demand_oscillations
from phichain.orbits.parameter.held import Held, held_of, times_of
from phichain.orbits.parameter.knob import Knob, knob_of
from phichain.orbits.parameter.problem import parameter_problem
from phichain.orbits.symmetry import brake_loss, discriminant, genuine, told
from phichain.system import Parameters, System, Vector
from phichain.system.arrays import number

SETTINGS: Final = Options(step=0.01, step_max=0.1, max_points=5000, tol=1e-9)
_AT_REST: Final = 1e-2
"""Share of the first amplitude at which an orbit of held frequency is back at rest."""
_NEAR_ZERO: Final = 1e-3
"""Share of the first value of a positive parameter at which a run ends."""


def vary(
    system: System,
    parameter: str,
    start: Any,
    until: float,
    *,
    hold: str = "amplitude",
    p: Parameters | None = None,
    options: Options | None = None,
    engine: Engine | None = None,
    progress: Progress | None = None,
) -> Branch:
    """Follow an orbit, or an event of a family, in a runtime parameter, one quantity of the orbit held.

    Held events make loci of two parameters: that of the family and the one that is turned.

    Args:
        system: A planar, undamped system whose flow carries derivatives by the parameter, `[flow] variational = ["state", "mass"]`.
        parameter: Its name, with [K] for link K: "mass[2]", "gravity".
        start: The orbit at the parameters' present values: a Branch of brake orbits, whose last point is meant; (Branch, k) for
            another one; an event of one; or (q_0, omega).
        until: The parameter's value at which the run ends, exactly.
        hold: "amplitude" (the angle that is largest at the start), "theta_K", "omega", "energy"; or the kind of an event that the orbit
            is: "fold omega", "fold amplitude K", "energy extremum", "brake loss", "odd loss", "unequal brakes", "krein", "cover K of mode J":
            there the shorter orbit, of mode J, is followed.
        p: Runtime parameters by name.
        options: Step control and limits.
        engine: Predictor, corrector and options together; excludes `options`.
        progress: Told every new point and the step to try next.

    Returns:
        The Branch, its unknowns (q_0, omega, parameter), with folds in the parameter, branch points and losses of stability.

    Raises:
        UnsupportedError: The flow carries no derivatives by the parameter, or the chain has no brake orbits.
        ArrayError: The parameter, the start or what is held is none of the chain's.
        ConvergenceError: Newton did not reach the orbit.
    """
    demand_oscillations(system)
    shooting.demand_shooting(system)
    knob, values = knob_of(system, parameter, p)
    first, end = _shorter(hold, _start(system, start)), number("until", until, "give the parameter's last value")
    begin = knob.of(values)
    if end == begin or not knob.allows(end):
        problem = "is where the run starts" if end == begin else f"is no value that {knob} can have"
        raise ArrayError("until", until, problem, "give another value of the parameter")
    held = held_of(system, hold, first)
    problem_ = parameter_problem(system, values, knob, held, first)
    chosen = engine or replace(shooting.settings(options), options=options or SETTINGS)
    direction = np.zeros(len(first) + 1)
    direction[-1] = np.sign(end - begin)
    try:
        point = start_on(problem_, np.append(first, begin), direction, chosen, fixed=True)
    except ConvergenceError as failure:
        raise ConvergenceError(
            "start", first.tolist(), f"is no orbit of '{system.name}' at these parameters, or no {hold} of its family ({failure.problem})",
            "start from a family traced with the same p, or hold another quantity",
        ) from failure  # fmt: skip
    tests = [*_tests(problem_, system, held, knob), *_ends(system, knob, held, first, begin, end)]
    branch = follow(problem_, point, chosen, tests, f"{system.name}, {hold} held, {knob} turned", progress=progress)
    events = tuple(told(event) for event in branch.events if genuine(event))
    reason = branch.reason
    if branch.status != "interrupted" and not (events and events[-1].kind == _named(knob, end)):
        reason = f"{reason}; {_named(knob, end)} was not reached"
    return replace(branch, events=events, reason=reason, scene=system.name, digest=system.digest, method=f"shooting in {knob}", p=system.values(values))


def turned(system: System, family: Branch, what: str, parameter: Any, **options: Any) -> Branch:
    """`vary` from where a family ended, "NAME[K]=VALUE" saying which parameter goes where.

    Raises:
        ArrayError: It says no such thing, or the family did not come to its orbit.
    """
    name, equals, value = parameter.partition("=") if isinstance(parameter, str) else ("", "", "")
    try:
        end = float(value)
    except ValueError:
        end = float("nan")
    if not equals or not np.isfinite(end):
        raise ArrayError("parameter", parameter, "is no NAME[K]=VALUE", 'write for example "mass[2]=3" or "gravity=1.62"')
    if family.status != "event" or "was not reached" in family.reason:
        raise ArrayError("until", family.reason, "is where the family ended, short of the orbit to go on with", "name an orbit that it reaches")
    return vary(system, name.strip(), family, end, hold=what, **options)


def _named(knob: Knob, value: float) -> str:
    return f"{knob} = {value!r}"


def _start(system: System, start: Any) -> Vector:
    """(q_0, omega).

    Raises:
        ArrayError: It is no brake orbit of a chain with so many angles.
    """
    remedy = "give a Branch of brake orbits, (Branch, k), one of its events, or (q_0, omega)"
    branch, place = (start, -1) if isinstance(start, Branch) else (None, -1)
    if isinstance(start, tuple) and len(start) == 2 and isinstance(start[0], Branch):
        branch, place = start
        if isinstance(place, bool) or not isinstance(place, int) or not -len(branch.points) <= place < len(branch.points):
            raise ArrayError("start", place, f"is no point of that branch, which has {len(branch.points)}", "count points from 0")
    if branch is not None:
        if branch.names[-1:] != ("omega",):
            raise ArrayError("start", branch.names, "are the unknowns of no family of brake orbits", remedy)
        z = branch.points[place]
    elif isinstance(start, Special):
        z = start.z
    elif isinstance(start, tuple | list) and len(start) == 2:
        z = np.append(np.asarray(start[0], float).ravel(), float(start[1]))
    else:
        raise ArrayError("start", start, "is no orbit", remedy)
    z = np.array(z, float)
    if z.shape != (system.nq + 1,) or not np.all(np.isfinite(z)) or z[-1] <= 0:
        raise ArrayError("start", z, f"is no brake orbit (q_0, omega) of {system.nq} coordinates at rest", remedy)
    return z


def _shorter(hold: Any, z: Vector) -> Vector:
    """The orbit that is covered, where that is held: it starts at the same rest, and comes back K times as often."""
    times = times_of(hold) if isinstance(hold, str) else 0
    return np.append(z[:-1], times * z[-1]) if times else z


def _tests(problem: Problem, system: System, held: Held, knob: Knob) -> list[TestFunction]:
    several: list[TestFunction] = [
        Quantity(brake_loss, "brake loss"),
        Quantity(lambda point: signed(point.extra.found.b), "odd loss"),
        Quantity(lambda point: signed(point.extra.found.c), "unequal brakes"),
        *([Quantity(discriminant, "krein")] if system.links > 2 else []),
    ]
    mine = [test for test in several if test.name != held.what]
    return [Fold(name=f"fold {knob}"), BranchPoint("branch point"), *(mine if system.links > 1 else [])]


def _ends(system: System, knob: Knob, held: Held, start: Vector, begin: float, end: float) -> list[TestFunction]:
    carts = system.cart_size
    largest = carts + int(np.argmax(np.abs(start[carts:-1])))

    def amplitude(z: Vector) -> float:
        return float(np.max(np.abs(z[carts:-2])))

    def turned(z: Vector) -> float:
        return float(z[-1])

    tests: list[TestFunction] = [
        Level(turned, end, _named(knob, end), held=lambda z: (len(z) - 1, end)),
        Level(amplitude, np.pi, "amplitude pi"),
    ]
    if held.what == "omega":
        # The angle goes through zero with all others, where the chain hangs at rest whatever the parameter is.
        tests.append(Level(lambda z: float(z[largest] / start[largest]), _AT_REST, "back at rest"))
    if not knob.allows(-1.0) and begin > 0 and end > _NEAR_ZERO * begin:
        tests.append(Level(turned, _NEAR_ZERO * begin, f"{knob} near zero"))
    return tests


