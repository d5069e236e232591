"""vary: an orbit of a family, or an event of one, followed in a parameter of the chain."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any, Final

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
    Special,
    TestFunction,
    follow,
    start_on,
)
from phichain.continuation.core import Progress
from phichain.continuation.problem import relative_residual
from phichain.errors import ArrayError, ConvergenceError
from phichain.orbits import shooting
from phichain.orbits.closed.kinds import KINDS, said_of
from phichain.orbits.forced.floquet import genuine as genuine_forced
from phichain.orbits.parameter.followed import AMPLITUDE, FORCED, Followed, Values
from phichain.orbits.parameter.held import Held, beside, held_of
from phichain.orbits.parameter.knob import Knob, demand_value, knob_of
from phichain.orbits.parameter.problem import parameter_problem
from phichain.orbits.parameter.starting import resumed, started
from phichain.orbits.symmetry import genuine, told
from phichain.system import Parameters, System, Vector
from phichain.system.arrays import number

SETTINGS: Final = Options(step=0.01, step_max=0.1, max_points=5000, tol=1e-9)
_AT_REST: Final = 1e-2
"""Share of the first amplitude at which an orbit of held frequency is back at rest."""
_NEAR_ZERO: Final = 1e-3
"""Share of the first value of a positive parameter at which a run ends."""
_SOLVED: Final = 1e-8
"""Relative residual beyond which a point to go on from is none of these equations."""


def vary(
    system: System,
    parameter: str,
    start: Any,
    until: float,
    *,
    hold: str | None = None,
    p: Parameters | None = None,
    resume: Branch | Path | str | None = None,
    options: Options | None = None,
    engine: Engine | None = None,
    progress: Progress | None = None,
) -> Branch:
    """Follow an orbit, or an event of a family, in a runtime parameter, one quantity of the orbit held.

    Held events make loci of two parameters: that of the family and the one that is turned.

    Args:
        system: An undamped system with what the orbits' own family needs, or a driven one; of planar orbits its flow has to carry derivatives by
            the parameter, `[flow] variational = ["state", "mass"]`.
        parameter: Its name, with [K] for link K: "mass[2]", "gravity"; of driven orbits "amplitude" is the forcing's.
        start: The orbit at the parameters' present values: a Branch, whose last point is meant, or a Response; (Branch, k) for
            another one; (Branch, event) for an event; "FILE.json:K" or "FILE.json:event=K" of one; (q_0, omega) of a brake orbit;
            {"q": ..., "v": ..., "period": ...}. None with `resume`.
        until: The parameter's value at which the run ends, exactly.
        hold: "amplitude" (the angle that is largest at the start), "omega", "energy", or an unknown such as "theta_K"; or the kind of an event
            that the orbit is ("fold omega", "brake loss", "krein", ..): of a "cover K of mode J" the shorter orbit, of mode J, is
            followed, and of a "branch point" at which a family meets its own mirror image, the orbit that has more symmetries. An event that the
            run starts at, unless said; else the amplitude, or what the orbits have instead: energy, and omega of driven ones.
        p: Runtime parameters by name.
        resume: An earlier run, or its file (.json, .npz), that is gone on with.
        options: Step control and limits.
        engine: Predictor, corrector and options together; excludes `options`.
        progress: Told every new point and the step to try next.

    Returns:
        The Branch, its unknowns those of the orbit, and the parameter; with folds in the parameter, branch points and losses of stability.

    Raises:
        UnsupportedError: The flow carries no derivatives by the parameter, or the chain has no such orbits.
        ArrayError: The parameter, the start or what is held is none of the chain's.
        ConvergenceError: Newton did not reach the orbit.
        OutputError: A file holds no such record.
    """
    earlier = _earlier(resume)
    given = dict(system.parameters(p).get("p", {}))
    if isinstance(parameter, str) and (name := parameter.partition("[")[0].strip()) in system.varied and name != AMPLITUDE:
        demand_value(name, given)
    followed, first, what, values = started(system, start, hold, given) if earlier is None else resumed(system, earlier, given)
    knob, values = _knob(system, parameter, followed, values)
    end = number("until", until, "give the parameter's last value")
    begin = knob.of(values)
    if end == begin or not knob.allows(end):
        problem = "is where the run starts" if end == begin else f"is no value that {knob} can have"
        raise ArrayError("until", until, problem, "give another value of the parameter")
    own = followed.family(values)
    held = held_of(followed, own, what or _usual(followed), first)
    value = _level(held, own, first, earlier)
    problem_ = parameter_problem(followed, values, knob, held, value)
    chosen = engine or replace(shooting.settings(options), options=options or SETTINGS)
    tests: list[TestFunction] = [Fold(name=f"fold {knob}"), BranchPoint("branch point"), *beside(followed, own, held)]
    tests += _ends(followed, knob, held, own, first, begin, end)
    if earlier is None:
        point: Point | Branch = _first(system, problem_, held, np.append(first, begin), end, chosen)
    else:
        point = _going_on(earlier, problem_, knob, end)
    branch = follow(problem_, point, chosen, tests, f"{system.name}, {held.what} held, {knob} turned", progress=progress)
    events = tuple(_told(followed, event) for event in branch.events if genuine(event) and genuine_forced(event))
    reason = branch.reason
    if branch.status != "interrupted" and not (events and events[-1].kind == _named(knob, end)):
        reason = f"{reason}; {_named(knob, end)} was not reached"
    method = followed.kind.partition(", ")[0]
    closing = f"{followed.kind}; {held.what}" + ("" if held.is_event else f" = {value!r}")
    return replace(
        branch, events=events, reason=reason, scene=system.name, digest=system.digest, closing=closing,
        method=f"{'shooting' if method in KINDS else method} in {knob}", states=np.array([followed.state(z[:-1]) for z in branch.points]),
        p=system.values(values),
    )  # fmt: skip


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
    demand_reached("until", family)
    return vary(system, name.strip(), family, end, hold=what, **options)


def demand_reached(field: str, family: Branch) -> None:
    """Refuse to go on from where a family ended short of the orbit that was asked for.

    Raises:
        ArrayError: It did not come there.
    """
    if family.status != "event" or "was not reached" in family.reason:
        raise ArrayError(field, family.reason, "is where the family ended, short of the orbit to go on with", "name an orbit that it reaches")


def _named(knob: Knob, value: float) -> str:
    return f"{knob} = {value!r}"


def _earlier(resume: Branch | Path | str | None) -> Branch | None:
    """The run to go on with; as JSON or NPZ by what the file begins with."""
    if resume is None or isinstance(resume, Branch):
        return resume
    return Branch.from_npz(resume) if Path(resume).suffix == ".npz" else Branch.from_json(resume)


def _knob(system: System, parameter: Any, followed: Followed, values: Values) -> tuple[Knob, Values]:
    """What is turned, and all parameters; the forcing's amplitude is one of driven orbits."""
    if followed.kind.startswith(FORCED) and parameter == AMPLITUDE:
        return Knob(AMPLITUDE, 0, 1, True), values
    mine = {name: value for name, value in values.items() if name != AMPLITUDE}
    knob, known = knob_of(system, parameter, mine, carried=followed.kind in KINDS)
    return knob, known | {name: values[name] for name in (AMPLITUDE,) if name in values}


def _usual(followed: Followed) -> str:
    """What is held unless said."""
    if followed.kind.startswith(FORCED):
        return "omega"
    return "amplitude" if followed.angles else "energy"


def _level(held: Held, own: Problem, first: Vector, earlier: Branch | None) -> float:
    """h_0: nothing of an event; of a run that is gone on with what its record says, to the last digit."""
    if held.is_event:
        return 0.0
    return held.at(own, first) if earlier is None else float(earlier.closing.rpartition(" = ")[2])


def _first(system: System, problem: Problem, held: Held, guess: Vector, end: float, engine: Engine) -> Point:
    """The orbit itself, the parameter as it is.

    Raises:
        ConvergenceError: Newton did not reach it.
    """
    direction = np.zeros(len(guess))
    direction[-1] = np.sign(end - guess[-1])
    try:
        return start_on(problem, guess, direction, engine, fixed=True)
    except ConvergenceError as failure:
        raise ConvergenceError(
            "start", guess[:-1].tolist(), f"is no orbit of '{system.name}' at these parameters, or no {held.what} of its family ({failure.problem})",
            "start from a family traced with the same p, or hold another quantity",
        ) from failure  # fmt: skip


def _going_on(earlier: Branch, problem: Problem, knob: Knob, end: float) -> Branch:
    """The run to go on with, if these are its equations and the value at which it is to end lies ahead of it.

    Raises:
        ArrayError: Another parameter is turned, the others have other values, or the run leads away from that value.
    """
    if earlier.names[-1] != str(knob):
        raise ArrayError("parameter", str(knob), f"is not what that run turned, {earlier.names[-1]}", "go on with the same parameter")
    _demand_ahead(earlier, knob, end)
    y = earlier.points[-1] / problem.sizes
    residual, jacobian, _ = problem.at(y)
    if not relative_residual(residual, jacobian, y) < _SOLVED or not np.array_equal(problem.sizes, earlier.scale):
        raise ArrayError("p", None, "are other parameters than that run's: its last point is no orbit of this chain", "give the same ones")
    return earlier


def _demand_ahead(earlier: Branch, knob: Knob, end: float) -> None:
    """Refuse a value that lies behind a run: gone on with, it leads away from there.

    Raises:
        ArrayError: It does.
    """
    last = max(earlier.regular, 1) - 1
    stands, slope = float(earlier.points[last, -1]), float(earlier.tangent[last, -1])
    if (end - stands) * slope < 0:
        problem = f"lies behind that run, which stands at {knob} = {stands!r} and goes on to {'larger' if slope > 0 else 'smaller'} values"
        remedy = f"give a value {'above' if slope > 0 else 'below'} {stands!r}, also where the run is to turn at a fold, or begin anew from an orbit"
        raise ArrayError("until", end, problem, remedy)


def _told(followed: Followed, event: Special) -> Special:
    """An event with what it breaks, and its state."""
    kind = followed.kind
    words = told(event) if kind in ("quarter", "in a plane") else said_of(kind, event) if kind in KINDS else event
    return replace(words, state=followed.state(event.z[:-1]))


def _ends(followed: Followed, knob: Knob, held: Held, own: Problem, start: Vector, begin: float, end: float) -> list[TestFunction]:
    angles = list(followed.angles)

    def turned(z: Vector) -> float:
        return float(z[-1])

    tests: list[TestFunction] = [Level(turned, end, _named(knob, end), held=lambda z: (len(z) - 1, end))]
    if followed.kind in ("quarter", "unequal", "in a plane"):
        tests.append(Level(lambda z: float(np.max(np.abs(z[angles]))), np.pi, "amplitude pi"))
    if held.what == "omega" and not followed.kind.startswith(FORCED):
        # The largest goes through zero with all others, where the chain hangs at rest whatever the parameter is.
        swinging = angles or [k for k, name in enumerate(own.names) if name not in ("unfolding", "turn", "omega", "x")]
        largest = max(swinging, key=lambda k: abs(start[k] / own.sizes[k]))
        tests.append(Level(lambda z: float(z[largest] / start[largest]), _AT_REST, "back at rest"))
    if not knob.allows(-1.0) and begin > 0 and end > _NEAR_ZERO * begin:
        tests.append(Level(turned, _NEAR_ZERO * begin, f"{knob} near zero"))
    return tests
