"""A frequency response by shooting over the forcing's period, or half of it where the forcing is odd."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any, Final

import numpy as np

from phichain.continuation import Branch, Engine, Point, Problem, follow, start_on
from phichain.continuation.core import Progress
from phichain.orbits.forced.begun import begun, towards
from phichain.orbits.forced.checkpoint import Checkpoint
from phichain.orbits.forced.floquet import tests_of
from phichain.orbits.forced.flow import EmittedFlow
from phichain.orbits.forced.forcing import Forcing
from phichain.orbits.forced.made import JOINED, Motion, ends_of, response_of
from phichain.orbits.forced.response import Response
from phichain.orbits.forced.shot import ForcedFlow, shooting_problem
from phichain.orbits.harmonics.basis import basis
from phichain.system import Parameters, System, Vector

_HIGHEST: Final = 63
"""Highest harmonic of the series that tell a shot motion's peaks; the motion itself is no series."""


def followed(
    system: System, forcing: Forcing, ends: tuple[float, float], p: Parameters | None, flow: ForcedFlow | None, engine: Engine,
    progress: Progress | None, earlier: Branch | None = None,
) -> Response:  # fmt: skip
    """The response between two frequencies, or an earlier one gone on with.

    Raises:
        UnsupportedError: The system has no flow that is forced there.
        ConvergenceError: Newton did not reach a solution at the first frequency.
    """
    moved: ForcedFlow = EmittedFlow(system, forcing, p) if flow is None else flow

    def problem_of(amplitude: float) -> Problem:
        return shooting_problem(system, replace(forcing, amplitude=amplitude), moved, omega=_typical(ends, earlier))

    problem = problem_of(forcing.amplitude)
    if earlier is not None:
        return _shot(system, forcing, ends, moved, engine, progress, problem, earlier)
    z = begun(problem_of, forcing.amplitude, np.append(np.zeros(2 * system.nq), ends[0]), ends, engine)
    start = start_on(problem, z, towards(z, ends), engine, fixed=True)
    return _shot(system, forcing, ends, moved, engine, progress, problem, start)


def gone_on(
    system: System, forcing: Forcing, ends: tuple[float, float], flow: ForcedFlow, engine: Engine, progress: Progress | None,
    first: Response, why: str, earlier: Branch | None = None,
) -> Response:  # fmt: skip
    """A response that harmonics cannot follow any further, gone on with from its last point.

    Args:
        first: What harmonics found.
        why: Why they do not go on.
        earlier: What an earlier run shot from there.
    """
    problem = shooting_problem(system, forcing, flow, omega=_typical(ends, earlier))
    places = np.column_stack([first.q[-2:], first.v[-2:], first.omega[-2:]])
    along = places[1] - places[0] if len(places) > 1 else towards(places[0], ends)
    start = start_on(problem, places[-1], along, engine) if earlier is None else earlier
    later = _shot(system, forcing, ends, flow, engine, progress, problem, start)
    stands = later.checkpoint
    seam, shift = float(first.arclength[-1]), len(first) - 1
    arrays: dict[str, Any] = {name: np.concatenate([getattr(first, name), getattr(later, name)[1:]]) for name in JOINED}
    events = tuple(replace(event, after=event.after + shift) for event in later.events)
    return replace(
        later, **arrays, name=first.name, method=first.method, arclength=np.concatenate([first.arclength, later.arclength[1:] + seam]),
        events=(*first.events, *events), reason=f"{later.reason}; {why}: behind that motions are shot",
        checkpoint=None if stands is None else replace(stands, before=shift, events=len(first.events), why=why),
    )  # fmt: skip


def _typical(ends: tuple[float, float], earlier: Branch | None) -> float:
    """The frequency that unknowns are scaled by: that of a run that is gone on with."""
    return max(ends) if earlier is None else float(earlier.scale[-1])


def _shot(
    system: System, forcing: Forcing, ends: tuple[float, float], moved: ForcedFlow, engine: Engine, progress: Progress | None,
    problem: Problem, start: Point | Branch,
) -> Response:  # fmt: skip
    """The response from its first point, or an earlier run gone on with."""
    branch = follow(problem, start, engine, [*tests_of(system, forcing.is_odd), *ends_of(ends)], "response", progress=progress)
    made = response_of(system, forcing, branch, "shooting", motion_of(system, forcing, moved))
    return replace(made, checkpoint=Checkpoint(branch))


def motion_of(system: System, forcing: Forcing, moved: ForcedFlow, periods: int | None = None) -> Callable[[Vector], Motion]:
    """Unknowns -> the motion as a series, over so many periods of the forcing, or by half of one where that is odd."""
    table = basis("odd" if forcing.is_odd and periods is None else "full", _HIGHEST * (periods or 1))

    def motion(z: Vector) -> Motion:
        n, omega, own = system.nq, float(z[-1]), float(z[-1]) / (periods or 1)
        states = moved.sampled(z[:-1], table.phase[1:] / own, forcing.amplitude, omega)
        return Motion(table, np.asarray(table.project @ np.vstack([z[:n], states[:, :n]])), own, z[:-1])

    return motion
