"""Runs that begin at an orbit instead of a linear mode, and runs that become networks."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

from phichain.continuation import Branch, Engine, Point
from phichain.continuation.core import Progress
from phichain.errors import ArrayError, OutputError
from phichain.orbits.closed.following import Follower
from phichain.orbits.closed.kinds import KINDS, problem_of
from phichain.orbits.closed.start import closed, given, towards
from phichain.orbits.modes import LinearModes
from phichain.orbits.network.growth import POINTS, Growing, grow
from phichain.orbits.network.record import Network
from phichain.orbits.targets import Target
from phichain.system import Parameters, System

MOST = 24
"""Branches of a network at most, unless said."""


def from_orbit(
    system: System,
    modes: LinearModes,
    start: Any,
    target: Target | None,
    *,
    p: Parameters | None,
    engine: Engine,
    through: float,
    earlier: Branch | None,
    progress: Progress | None,
) -> Branch:
    """Follow the family of an orbit, closed by Newton first, with rising energy or towards the target.

    Args:
        system: The chain.
        modes: Its linear modes.
        start: The orbit (`start.given`).
        target: Where to end.
        p: Runtime parameters.
        engine: Predictor, corrector and options.
        through: Half width of gaps that are crossed.
        earlier: A run to go on with.
        progress: Told every new point.

    Raises:
        ArrayError: It is no orbit of the chain, or its kind has no such target.
        ConvergenceError: Newton closed none nearby.
    """
    follower = Follower(system, p, modes, engine, through, progress)
    first: Point | Branch
    if earlier is not None:
        kind, first = earlier.closing, earlier
        problem = replace(problem_of(system, p, kind, earlier.points[0]), scale=earlier.scale)
    else:
        kind, problem, point = closed(system, p, *given(system, start))
        _demand_target(kind, target)
        first = towards(system, problem, point, target)
    tests = [] if target is None else [target.level(system, problem)]
    name = f"{system.name}, {KINDS[kind].words}, from an orbit"
    return replace(follower.follow(kind, problem, first, name, tests), mode=0)


def _demand_target(kind: str, target: Target | None) -> None:
    """Refuse a target that families of a kind do not have.

    Raises:
        ArrayError: It has none.
    """
    if target is not None and target.what not in ("omega", "energy") and kind not in ("quarter", "unequal"):
        raise ArrayError(
            "until", target.what, f"is no quantity of {KINDS[kind].words}: they do not start at a rest", 'use "omega=..." or "energy=..."'
        )


def switched(
    system: System,
    modes: LinearModes,
    first: Branch | Network,
    *,
    p: Parameters | None,
    engine: Engine,
    through: float,
    generations: int,
    progress: Progress | None,
) -> Network:
    """The network of a branch, or an earlier network gone on with.

    Args:
        system: The chain.
        modes: Its linear modes.
        first: The branch, or the network.
        p: Runtime parameters.
        engine: Predictor, corrector and options; a branch that an event opens has 400 points at most.
        through: Half width of gaps that are crossed.
        generations: How far from the first branch events are gone through.
        progress: Told every new point.
    """
    options = replace(engine.options, max_points=min(POINTS, engine.options.max_points))
    return grow(Growing(system, p, modes, replace(engine, options=options), through, progress, generations, MOST), first)


def earlier_run(resume: Network | Branch | Path | str | None, switch: bool) -> Network | Branch | None:
    """What a run is to go on from: a Branch, or a Network where branches are switched to.

    Raises:
        OutputError: Its file cannot be read.
        ArrayError: It is a network, and none is asked for.
    """
    if isinstance(resume, Network) and not switch:
        raise ArrayError("resume", resume.name, "is a network, and one branch is asked for", "say switch = True (--switch)")
    if not isinstance(resume, Path | str):
        return resume
    if not switch:
        return Branch.from_json(resume)
    try:
        return Network.from_json(resume)
    except OutputError as no_network:
        try:
            return Branch.from_json(resume)
        except OutputError:
            raise no_network from None
