"""respond: the periodic motions of a driven chain along the forcing's frequency, by the method that fits."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, Final

from phichain.continuation import Engine, Options, predictors
from phichain.continuation.core import Progress
from phichain.errors import ArrayError
from phichain.orbits.forced import beyond as opened
from phichain.orbits.forced import by_harmonics, by_shooting
from phichain.orbits.forced.forcing import Forcing, forcing_of, range_of
from phichain.orbits.forced.response import Response
from phichain.orbits.forced.shot import ForcedFlow
from phichain.orbits.harmonics.elimination import Harmonics
from phichain.orbits.run import demand_same
from phichain.orbits.tracing import limited
from phichain.system import Parameters, System

METHODS: Final = ("harmonics", "shooting")


def respond(
    system: System,
    forced: int | str | None = None,
    amplitude: float | None = None,
    omega: Any = None,
    *,
    axis: int | None = None,
    method: str = "harmonics",
    p: Parameters | None = None,
    harmonics: Harmonics | int | None = None,
    flow: ForcedFlow | None = None,
    beyond: tuple[Response, int] | None = None,
    resume: Response | Path | str | None = None,
    options: Options | None = None,
    limits: Mapping[str, Any] | None = None,
    progress: Progress | None = None,
) -> Response:
    """Follow the periodic motions of a chain under A cos(omega t) from one frequency to another, through folds.

    Args:
        system: A planar chain, usually with losses, with `inverse_and_jacobian`.
        forced: What is driven: a joint (its torque), "cart" (the force on it, or its acceleration where that drives it) or "base" (its
            acceleration); what the scene's [forcing] says unless given.
        amplitude: A, N m, N or m/s^2.
        omega: (from, to), rad/s.
        axis: Along which axis a base is accelerated: 1 horizontally, 2 down.
        method: "harmonics": Fourier series by harmonic balance; "shooting": over the forcing's period, on the emitted forced flow.
        p: Runtime parameters by name.
        harmonics: How many harmonics are kept, or the highest alone; by the tail of the spectrum unless said.
        flow: The forced motion that shooting integrates by; the system's own unless given.
        beyond: (response, K): the branch that its K-th event, counted from 1, opens, between the two frequencies, by shooting
            (`orbits.forced.beyond`): motions without their symmetry, or of twice the period.
        resume: An earlier Response of the same chain, forcing and method, or its JSON file, that is gone on with bit by bit as if it had not ended; one
            beyond an event goes on there.
        options: Step control and limits.
        limits: Options that replace those the method would take by itself, by name.
        progress: Told every new point and the step to try next.

    Returns:
        The Response, its folds and the places where stability is lost located.

    Raises:
        ArrayError: Nothing or nothing that is there is forced, there is no range of frequencies, or another scene, forcing or method the response to resume.
        OutputError: A file holds no Response, or not a whole one.
        UnsupportedError: The scene is spatial, or lacks what the method needs.
        ConvergenceError: Newton did not reach a periodic motion at the first frequency.
    """
    if method not in METHODS:
        raise ArrayError("method", method, "is no method", f"use one of {', '.join(METHODS)}")
    forcing = forcing_of(system, forced, amplitude, axis)
    ends = range_of(omega)
    chosen = options or Options(step=0.02, step_max=0.2, max_points=4000, tol=1e-9)
    if options is not None and not isinstance(options, Options):
        raise ArrayError("options", options, "is no Options", "leave it out, or make one")
    engine = Engine(predictors.cubic, options=limited(chosen, limits) if limits else chosen)
    earlier = None if resume is None else _resumed(resume, system, forcing, method, p, beyond)
    if earlier is not None and earlier.checkpoint is not None and earlier.checkpoint.opened:
        found = opened.gone_on(system, forcing, earlier, earlier.checkpoint, ends, p, flow, engine, progress)
    elif beyond is not None:
        found = opened.beyond(system, forcing, *_pair(beyond), ends, p, flow, engine, progress)
    elif method == "shooting":
        if harmonics is not None:
            raise ArrayError("harmonics", harmonics, 'belong to method = "harmonics"', "leave them out")
        found = by_shooting.followed(
            system, forcing, ends, p, flow, engine, progress, None if earlier is None or earlier.checkpoint is None else earlier.checkpoint.branch
        )
    else:
        found = by_harmonics.followed(system, forcing, ends, p, kept(harmonics), engine, progress, earlier)
    return replace(found, p=system.values(p))


def _resumed(
    resume: Any, system: System, forcing: Forcing, method: str, p: Parameters | None, beyond: Any
) -> Response:  # fmt: skip
    """The response to go on with.

    Raises:
        ArrayError: It is of another scene, forcing or method, or says not where it stands.
        OutputError: Its file cannot be read.
    """
    earlier = Response.from_json(resume) if isinstance(resume, Path | str) else resume
    if not isinstance(earlier, Response):
        raise ArrayError("resume", resume, "is no Response", "give one, or the JSON file of one")
    at = earlier.checkpoint
    if at is None or at.branch.regular < 1 or at.branch.step <= 0:
        raise ArrayError("resume", earlier.name, "does not say where the run stands", "name the JSON file that it wrote, or follow it anew")
    if beyond is not None:
        raise ArrayError("beyond", beyond[1] if isinstance(beyond, tuple) else beyond, "is given, and so is resume", "leave one of them out")
    facts = (
        ("digest", earlier.digest, system.digest), ("place", earlier.place, forcing.place), ("amplitude", earlier.amplitude, forcing.amplitude),
        ("method", earlier.method, earlier.method if at.opened else method),
    )  # fmt: skip
    demand_same(system, earlier, facts, "scene, forcing and method", p)
    return earlier


def _pair(given: Any) -> tuple[Response, Any]:
    if not (isinstance(given, tuple) and len(given) == 2 and isinstance(given[0], Response)):
        raise ArrayError("beyond", given, "is no (Response, K)", "give a response and the number of its event, from 1")
    return given


def kept(given: Harmonics | int | None) -> Harmonics:
    """How many harmonics are meant."""
    if given is None:
        return by_harmonics.USUAL
    if isinstance(given, Harmonics):
        return given
    return Harmonics(most=given, least=given)

