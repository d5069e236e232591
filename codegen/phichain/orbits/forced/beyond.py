"""What the events of a frequency response open: motions without their symmetry, and motions of twice the period.

Where a motion with q(t + T/2) = -q(t) loses that, or one comes back only after two periods, the closing x(k T) = x(0) of what has less has a
second null vector: w with Phi(k T) w = w, which is no matter of omega. Newton starts a little way out along it and stays in the plane across it; the
other side is the mirror image, or the same motion a period later. Such a branch ends where it has again what it lost (a reverse of its
event), or where the range does.
"""

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
    Point,
    Problem,
    Quantity,
    TestFunction,
    follow,
    start_on,
)
from phichain.continuation.core import Progress
from phichain.errors import ArrayError, ConvergenceError
from phichain.orbits.forced.by_shooting import motion_of
from phichain.orbits.forced.checkpoint import Checkpoint
from phichain.orbits.forced.floquet import circle_of, plus_one
from phichain.orbits.forced.flow import EmittedFlow
from phichain.orbits.forced.forcing import Forcing
from phichain.orbits.forced.made import response_of
from phichain.orbits.forced.response import Response
from phichain.orbits.forced.shot import ForcedFlow, shooting_problem
from phichain.system import Parameters, System, Vector

OPENED: Final = {"symmetry breaking": 1, "period doubling": 2}
"""Event -> by how many the periods of what it opens are more."""
_OUT: Final = (2e-2, 5e-3, 5e-2, 1e-3)
"""How far out Newton starts, rad, one after the other."""
_SAME: Final = 1e-5
"""Distance, relative, within which a motion has what its branch had lost; an event is located to about 1e-8."""


def beyond(
    system: System, forcing: Forcing, first: Response, number: int, ends: tuple[float, float], p: Parameters | None,
    flow: ForcedFlow | None, engine: Engine, progress: Progress | None,
) -> Response:  # fmt: skip
    """The branch that an event of a response opens, followed by shooting.

    Args:
        system: A planar chain whose flow is forced there.
        forcing: What drives it.
        first: The response.
        number: Which of its events, from 1.
        ends: Frequencies between which it is followed, rad/s.
        p: Runtime parameters.
        flow: The forced motion; the system's own unless given.
        engine: Predictor, corrector and options.
        progress: Told every new point.

    Raises:
        ArrayError: The response belongs to another scene or forcing, has no such event, or it opens nothing.
        UnsupportedError: The system has no flow that is forced there.
        ConvergenceError: Newton found no motion beside it.
    """
    wanted = (system.digest, str(forcing.forced), forcing.amplitude)
    if (first.digest, first.forced, first.amplitude) != wanted:
        raise ArrayError("response", first.name, f"is of another scene, place or amplitude than {wanted}", "go on with the same ones")
    if isinstance(number, bool) or not isinstance(number, int) or not 1 <= number <= len(first.events):
        raise ArrayError("beyond", number, f"is none of the response's {len(first.events)} events", "count them from 1")
    event = first.events[number - 1]
    if event.kind not in OPENED:
        raise ArrayError("beyond", event.kind, "opens no branch", f"choose an event that is one of {', '.join(OPENED)}")
    z = np.concatenate([event.q, event.v, [event.omega]])
    made = _followed(system, forcing, event.kind, first.periods * OPENED[event.kind], ends, p, flow, engine, progress, z)
    return replace(made, name=f"{made.name}, beyond the {event.kind} at {event.omega:.9g} rad/s")


def gone_on(
    system: System, forcing: Forcing, earlier: Response, at: Checkpoint, ends: tuple[float, float], p: Parameters | None,
    flow: ForcedFlow | None, engine: Engine, progress: Progress | None,
) -> Response:  # fmt: skip
    """The same, gone on with from where it stands.

    Raises:
        UnsupportedError: The system has no flow that is forced there.
    """
    made = _followed(system, forcing, at.opened, earlier.periods, ends, p, flow, engine, progress, at.branch)
    return replace(made, name=earlier.name)


def _followed(
    system: System, forcing: Forcing, kind: str, periods: int, ends: tuple[float, float], p: Parameters | None, flow: ForcedFlow | None,
    engine: Engine, progress: Progress | None, begin: Vector | Branch,
) -> Response:  # fmt: skip
    """The branch that an event of some kind opens at the unknowns z, of motions of so many periods; or what there is of it."""
    moved: ForcedFlow = EmittedFlow(system, forcing, p) if flow is None else flow
    typical = float(begin.scale[-1]) if isinstance(begin, Branch) else max(ends)
    problem = shooting_problem(system, forcing, moved, omega=typical, periods=periods)
    shorter = None if OPENED[kind] == 1 else periods // OPENED[kind]
    before = shooting_problem(system, forcing, moved, omega=typical, periods=shorter)

    def regained(problem: Problem, point: Point) -> bool:
        at = point.z(problem)
        return bool(np.max(np.abs(before.evaluate(at).residual / problem.sizes[:-1])) < _SAME)

    low, high = sorted(ends)
    tests: list[TestFunction] = [
        Fold(name="fold"), BranchPoint(ends=regained), Quantity(plus_one, "period doubling"), *circle_of(system),
        Level(lambda z: float(z[-1]), low, "end of the range", held=lambda z: (len(z) - 1, low)),
        Level(lambda z: float(z[-1]), high, "end of the range", held=lambda z: (len(z) - 1, high)),
    ]  # fmt: skip
    start = begin if isinstance(begin, Branch) else _entered(problem, begin, engine)
    branch = follow(problem, start, engine, tests, "response", progress=progress)
    reason = branch.reason
    if branch.status == "event" and branch.events[-1].kind == "branch point":
        reason = "ended where it has again what it lost: the motion's symmetry" if shorter is None else "ended at a motion of half its period"
    made = response_of(system, forcing, replace(branch, reason=reason), "shooting", motion_of(system, forcing, moved, periods), periods)
    return replace(made, checkpoint=Checkpoint(branch, opened=kind))


def _entered(problem: Problem, z: Vector, engine: Engine) -> Point:
    """The first motion beyond an event, beside z.

    Raises:
        ConvergenceError: There is none.
    """
    jacobian: Any = problem.at(z / problem.sizes).jacobian[:, :-1]
    across = np.append(np.linalg.svd(jacobian)[2][-1], 0.0)
    failure: ConvergenceError | None = None
    for far in _OUT:
        try:
            return start_on(problem, z + far * across * problem.sizes, across * problem.sizes, engine, fixed=True)
        except ConvergenceError as said:
            failure = said
    assert failure is not None
    raise failure
