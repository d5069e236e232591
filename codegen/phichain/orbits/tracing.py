"""trace: one family of limit cycles from one linear mode, by the method that fits."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import fields, replace
from functools import partial
from pathlib import Path
from typing import Any, Final, cast

import numpy as np

from phichain.continuation import Branch, Engine, Options
from phichain.continuation.core import Progress
from phichain.errors import ArrayError, ToleranceError, UnsupportedError
from phichain.orbits import in_plane, in_space, shooting, single_harmonic, unmirrored
from phichain.orbits.conical import conical_starts, families
from phichain.orbits.harmonics import family as many_harmonics
from phichain.orbits.harmonics.condensed import Harmonics, kept_harmonics
from phichain.orbits.modes import linear_modes
from phichain.orbits.network.record import Network
from phichain.orbits.network.runs import earlier_run, from_orbit, switched
from phichain.orbits.parameter.vary import turned
from phichain.orbits.run import Run, demand_same
from phichain.orbits.targets import Target, target_of
from phichain.orbits.whirling import families as whirling
from phichain.orbits.whirling.starts import METHOD as WHIRLING
from phichain.orbits.whirling.starts import whirls_of
from phichain.system import Parameters, System, given_system
from phichain.system.arrays import positive, whole

_FAMILIES: Final[dict[str, tuple[Any, Callable[..., Any], Callable[..., Branch]]]] = {
    "shooting": (shooting, linear_modes, shooting.trace_shooting),
    "harmonics": (many_harmonics, linear_modes, many_harmonics.trace_harmonics),
    "one harmonic": (single_harmonic, linear_modes, single_harmonic.trace_one_harmonic),
    "conical": (families, conical_starts, families.trace_conical),
    "in a plane": (in_plane, in_plane.plane_modes, in_plane.trace_in_plane),
    WHIRLING: (whirling, whirls_of, whirling.trace_whirling),
    in_space.METHOD: (in_space, in_space.from_plane, in_space.trace_in_space),
    unmirrored.METHOD: (unmirrored, unmirrored.from_whirl, unmirrored.trace_unmirrored),
}
"""The module that knows a method, where its families begin, and what traces by it."""
METHODS: Final = ("auto", "one harmonic", "harmonics", "shooting", "conical", "in a plane", WHIRLING, in_space.METHOD, unmirrored.METHOD)
_BEGUN: Final = (WHIRLING, in_space.METHOD, unmirrored.METHOD)
"""Methods whose families begin at orbits of others."""


def trace(
    system: System,
    mode: int = 1,
    amplitude_max: float | None = None,
    *,
    method: str = "auto",
    until: Any = None,
    through: float | None = None,
    switch: bool = False,
    generations: int = 1,
    start: Any = None,
    hold: str | None = None,
    resume: Branch | Network | Path | str | None = None,
    p: Parameters | None = None,
    parameter: str | None = None,
    amplitude_start: float | None = None,
    options: Options | None = None,
    engine: Engine | None = None,
    limits: Mapping[str, Any] | None = None,
    harmonics: Harmonics | int | None = None,
    progress: Progress | None = None,
) -> Branch | Network:
    """Follow the family of limit cycles that one linear mode starts, from small amplitudes, or that of any orbit.

    Args:
        system: A planar, undamped system; a spatial one for conical families.
        mode: Number of the mode, from 1, by rising linear frequency; of a conical family where it begins (`conical_starts`); of a whirling one
            which small motion beside the conical orbit it grows from.
        amplitude_max: The run ends where the largest angle reaches this, rad; pi unless `until` says where.
        method: "shooting": orbits of the whole equations, with their stability; "harmonics": the same orbits as Fourier series, as long as
            the tail of their spectrum asks for; "one harmonic": theta_k = A_k cos(omega t), an approximation that carries the first omitted
            harmonic as its error; "conical": a spatial chain turning about the vertical at a constant rate; "in a plane": one that
            swings in a vertical plane, with what is beside it in space; "whirling": one that comes back turned about the vertical, from
            `start`; "in space": one that stands still off any plane, and "unmirrored": one that comes back turned
            and has no reversal, both from an event as `start`; "auto": shooting or conical where the system can.
        until: "WHAT=VALUE" (or {WHAT: VALUE}), WHAT theta_K (an angle of the start), amplitude (the largest), omega or
            energy: the last point lies exactly there.
        through: Half width, in arclength, up to which a gap is crossed instead of followed.
        switch: Follow the branches that events open, too, and those that their events open.
        generations: How far from the first branch events are gone through with `switch`.
        start: An orbit to start from instead of a mode, closed by Newton first (`orbits.closed.start.given`): a Branch, (Branch, point), "FILE.json:POINT",
            or {"q": ..., "v": ..., "period": ...}; its family is followed with rising energy, or towards `until`. A whirling family begins at a
            conical orbit, at one in a plane, or at an event of these (`orbits.whirling.starts.whirls_of`).
        hold: What is held along a whirling family: "momentum" about the vertical (unless said), "energy", or "turn", the angle by which its
            orbits come back turned.
        resume: A Branch (with `switch` a Network, too), or the JSON file of one, that is gone on with.
        p: Runtime parameters by name.
        parameter: "NAME[K]=VALUE": from where the family ends, the run goes on in that parameter of the chain to its value, what `until`
            names being held (`orbits.parameter.vary`, which takes events and any orbit, too); the Branch is of that alone.
        amplitude_start: Largest angle of the first point, rad; 1e-2, and 1e-3 of one harmonic.
        options: Step control and limits.
        engine: Predictor, corrector and options together; excludes `options`.
        limits: Options that replace those the method would take by itself, by name, such as {"step_max": 0.02}.
        harmonics: How many harmonics the method of that name keeps, or the highest alone; by the tail of the spectrum unless said.
        progress: Told every new point and the step to try next.

    Returns:
        The Branch, with its events, its passages of avoided crossings and the reason why it ended; with `switch` the Network of it and of all
        that its events open. Ctrl-C ends them too, with the status "interrupted".

    Raises:
        AbsentFunctionError: The system lacks a function.
        UnsupportedError: The scene is spatial or damped, or the method does not serve.
        ArrayError: No mode has that number, no family that target, or another scene the branch to resume.
        ToleranceError: Amplitudes not positive, or start not below the end.
        ConvergenceError: Newton did not reach the family.
    """
    chosen = _method(given_system(system), method, switch or (start is not None and method not in _BEGUN))
    if hold is not None and chosen != WHIRLING:
        raise ArrayError("hold", hold, f"is for whirling families, and method is {chosen!r}", 'leave it out, or use method = "whirling"')
    family, begin, follow = _FAMILIES[chosen]
    if amplitude_start is None:
        amplitude_start = min(family.START, _before(target_of(system, until)))
    amplitude_start = positive("amplitude_start", amplitude_start, "give an angle in rad")
    is_open = chosen in ("conical", *_BEGUN) and until is None and amplitude_max is None
    target = None if is_open else _target(system, until, amplitude_max, amplitude_start)
    if parameter is not None and target is not None:
        begun = trace(system, mode, method=method, until=target, through=through, p=p, limits=limits, progress=progress)
        return turned(system, cast(Branch, begun), target.what, parameter, p=p, options=options, engine=engine, progress=progress)
    through = 0.0 if through is None else positive("through", through, "give a half width in arclength, such as 1e-4")
    generations = whole("generations", generations, 1, 2**31, "give a number of generations, such as 2", ArrayError)
    loaded = earlier_run(resume, switch)
    earlier = loaded.branches[0] if isinstance(loaded, Network) else loaded
    begins = chosen in _BEGUN
    modes: Any
    if begins:
        # Gone on with, a family says itself what it is of.
        modes = (None,) * earlier.mode if earlier is not None else begin(system, start, p)
        follow = partial(follow, hold=hold or "momentum") if chosen == WHIRLING else follow
    else:
        modes = begin(system, p)
    mode = whole("mode", mode, 1, len(modes), f"this chain has the modes 1 .. {len(modes)}", ArrayError)
    for field, given, kind in (("options", options, Options), ("engine", engine, Engine)):
        if given is not None and not isinstance(given, kind):
            raise ArrayError(field, given, f"is no {kind.__name__}", "leave it out, or make one")
    if harmonics is not None:
        follow = partial(follow, harmonics=kept_harmonics(harmonics, chosen))
    chosen_engine = engine or (shooting.settings(options, system.links) if family is shooting else family.settings(options))
    if limits:
        chosen_engine = replace(chosen_engine, options=limited(chosen_engine.options, limits))
    is_begun = not begins and (start is not None or (earlier is not None and earlier.mode == 0))
    mode = 0 if is_begun else mode
    _demand_same(system, earlier, mode, chosen, p)
    if isinstance(loaded, Network) and earlier is not None and earlier.status != "interrupted":
        branch, grown = earlier, loaded
    else:
        common: dict[str, Any] = {"p": p, "engine": chosen_engine, "through": through, "earlier": earlier, "progress": progress}
        if is_begun:
            # An orbit's family ends nowhere unless said, a mode's at pi.
            aim = target if until is not None or amplitude_max is not None else None
            branch = from_orbit(system, modes, start, aim, **common)
        else:
            aim = target
            branch = follow(system, modes, mode, target, Run(amplitude_start=amplitude_start, **common))
        reason = branch.reason
        if aim is not None and branch.status != "interrupted" and not (branch.events and branch.events[-1].kind == str(aim)):
            reason = f"{reason}; {aim} was not reached"
        branch, grown = replace(branch, reason=reason, scene=system.name, digest=system.digest, p=system.values(p), method=chosen, mode=mode), None
    if not switch:
        return branch
    return switched(
        system, modes, grown or branch, p=p, engine=chosen_engine, through=through, generations=generations, progress=progress
    )


def limited(options: Options, limits: Mapping[str, Any]) -> Options:
    """Options with some replaced, the first step and the smallest no longer than the largest.

    Raises:
        ArrayError: There is no option of that name.
        ToleranceError: A value is none that it could have.
    """
    known = {item.name for item in fields(Options)}
    for name in limits:
        if name not in known:
            raise ArrayError("limits", name, "is no option", f"use {', '.join(sorted(known))}")
    most = positive("limits.step_max", limits.get("step_max", options.step_max), "give a length")
    first = {"step": min(options.step, most), "step_min": min(options.step_min, most)}
    return replace(options, **{**first, **limits})


def _method(system: System, method: str, beyond: bool) -> str:
    """The method that is meant.

    Raises:
        UnsupportedError: There is none such yet.
        ArrayError: There is none of that name.
    """
    if method not in METHODS:
        raise ArrayError("method", method, "is no method", f"use one of {', '.join(METHODS)}")
    if beyond:
        if method in ("one harmonic", "harmonics", "conical", "in a plane", *_BEGUN):
            raise UnsupportedError(
                "method", method, "events that open branches, and orbits to start from, are those of shooting", 'use method = "shooting"'
            )
        shooting.demand_shooting(system, (*shooting.NEEDED, "forward_dynamics"))
        return "shooting"
    if method == "auto":
        if not system.is_planar:
            return "conical"
        return "one harmonic" if shooting.lacks(system) else "shooting"
    return method


def _before(target: Target | None) -> float:
    """An amplitude from which a target that is an angle still lies ahead, rad."""
    if target is None or target.value == 0 or target.what in ("omega", "energy"):
        return float("inf")
    return abs(target.value) / 2


def _target(system: System, until: Any, amplitude_max: float | None, start: float) -> Target:
    """Where to end.

    Raises:
        ToleranceError: Start and end do not rise.
        ArrayError: Both are given, or `until` is no target.
    """
    target = target_of(system, until)
    if target is not None and amplitude_max is not None:
        raise ArrayError("until", until, "is given, and so is amplitude_max", "leave one of them out")
    if target is not None:
        return target
    end = positive("amplitude_max", np.pi if amplitude_max is None else amplitude_max, "give an angle in rad")
    if not start < end:
        raise ToleranceError(
            "amplitude_start, amplitude_max",
            (start, end),
            "must be positive, finite and rising",
            "leave the start out, and end at a larger angle in rad, such as 3",
        )
    return Target("amplitude", end, "amplitude_max")


def _demand_same(system: System, branch: Branch | None, mode: int, method: str, p: Parameters | None) -> None:
    """Refuse to go on with what is of another kind.

    Raises:
        ArrayError: It belongs to another scene, mode or method, or has no points of its own.
    """
    if branch is None:
        return
    facts = ("digest", branch.digest, system.digest), ("mode", branch.mode, mode), ("method", branch.method, method)
    demand_same(system, branch, facts, "scene, mode and method", p)
    if branch.regular < 1 or branch.step <= 0:
        raise ArrayError("resume", branch.regular, "points of that branch are a run's own", "trace it anew")
