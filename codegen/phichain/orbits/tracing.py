"""trace: one family of limit cycles from one linear mode, by the method that fits."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, replace
from pathlib import Path
from typing import Any, Final

import numpy as np

from phichain.continuation import Branch, Engine, Options
from phichain.continuation.core import Progress
from phichain.errors import ArrayError, ToleranceError, UnsupportedError
from phichain.orbits import shooting, single_harmonic
from phichain.orbits.modes import linear_modes
from phichain.orbits.targets import Target, target_of
from phichain.system import Parameters, System, given_system
from phichain.system.arrays import positive, whole

METHODS: Final = ("auto", "one harmonic", "harmonics", "shooting")


def trace(
    system: System,
    mode: int = 1,
    amplitude_max: float | None = None,
    *,
    method: str = "auto",
    until: Any = None,
    through: float | None = None,
    switch: bool = False,
    resume: Branch | Path | str | None = None,
    p: Parameters | None = None,
    amplitude_start: float | None = None,
    options: Options | None = None,
    engine: Engine | None = None,
    limits: Mapping[str, Any] | None = None,
    progress: Progress | None = None,
) -> Branch:
    """Follow the family of limit cycles that one linear mode starts, from small amplitudes.

    Args:
        system: A planar, undamped system.
        mode: Number of the mode, from 1, by rising linear frequency.
        amplitude_max: The run ends where the largest angle reaches this, rad; pi unless `until` says where.
        method: "shooting": orbits of the whole equations, with their stability; "one harmonic": theta_k = A_k cos(omega t), an
            approximation that carries the first omitted harmonic as its error; "auto": shooting where the system can.
        until: "WHAT=VALUE" (or {WHAT: VALUE}), WHAT theta_K (an angle of the start), amplitude (the largest), omega or
            energy: the last point lies exactly there.
        through: Half width, in arclength, up to which a gap is crossed instead of followed.
        switch: Follow the branches that events open, too.
        resume: A Branch, or the JSON file of one, that is gone on with.
        p: Runtime parameters by name.
        amplitude_start: Largest angle of the first point, rad; 1e-2, and 1e-3 of one harmonic.
        options: Step control and limits.
        engine: Predictor, corrector and options together; excludes `options`.
        limits: Options that replace those the method would take by itself, by name, such as {"step_max": 0.02}.
        progress: Told every new point and the step to try next.

    Returns:
        The Branch, with its events, its passages of avoided crossings and the reason why it ended. Ctrl-C ends it too, with the
        status "interrupted".

    Raises:
        AbsentFunctionError: The system lacks a function.
        UnsupportedError: The scene is spatial or damped, or the method does not serve.
        ArrayError: No mode has that number, no family that target, or another scene the branch to resume.
        ToleranceError: Amplitudes not positive, or start not below the end.
        ConvergenceError: Newton did not reach the family.
    """
    chosen = _method(given_system(system), method, switch)
    usual = shooting.START if chosen == "shooting" else single_harmonic.START
    if amplitude_start is None:
        amplitude_start = min(usual, _before(target_of(system, until)))
    amplitude_start = positive("amplitude_start", amplitude_start, "give an angle in rad")
    target = _target(system, until, amplitude_max, amplitude_start)
    through = 0.0 if through is None else positive("through", through, "give a half width in arclength, such as 1e-4")
    modes = linear_modes(system, p)
    mode = whole("mode", mode, 1, len(modes.omega), f"this chain has the modes 1 .. {len(modes.omega)}", ArrayError)
    for field, given, kind in (("options", options, Options), ("engine", engine, Engine)):
        if given is not None and not isinstance(given, kind):
            raise ArrayError(field, given, f"is no {kind.__name__}", "leave it out, or make one")
    earlier = _earlier(system, resume, mode, chosen)
    family = shooting if chosen == "shooting" else single_harmonic
    follow = shooting.trace_shooting if chosen == "shooting" else single_harmonic.trace_one_harmonic
    chosen_engine = engine or family.settings(options)
    if limits:
        chosen_engine = replace(chosen_engine, options=_limited(chosen_engine.options, limits))
    branch = follow(
        system, modes, mode, target, p=p, amplitude_start=amplitude_start, engine=chosen_engine,
        through=through, earlier=earlier, progress=progress,
    )  # fmt: skip
    reason = branch.reason
    if branch.status != "interrupted" and not (branch.events and branch.events[-1].kind == str(target)):
        reason = f"{reason}; {target} was not reached"
    return replace(branch, reason=reason, scene=system.name, digest=system.digest, method=chosen, mode=mode)


def _limited(options: Options, limits: Mapping[str, Any]) -> Options:
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


def _method(system: System, method: str, switch: bool) -> str:
    """The method that is meant.

    Raises:
        UnsupportedError: There is none such yet.
        ArrayError: There is none of that name.
    """
    if method not in METHODS:
        raise ArrayError("method", method, "is no method", f"use one of {', '.join(METHODS)}")
    if method == "harmonics":
        raise UnsupportedError(
            "method", method, "many harmonics are not balanced here",
            'use method = "shooting", which has all of them, or "one harmonic"',
        )  # fmt: skip
    if switch:
        raise UnsupportedError(
            "switch", switch, "branches that events open are not followed by themselves",
            "trace the mode that a cover names, and read `continues` of the other events",
        )  # fmt: skip
    if method == "auto":
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


def _earlier(system: System, resume: Branch | Path | str | None, mode: int, method: str) -> Branch | None:
    """The run to go on with.

    Raises:
        ArrayError: It is none, or belongs to another scene, mode or method.
        OutputError: Its file cannot be read.
    """
    if resume is None:
        return None
    branch = resume if isinstance(resume, Branch) else Branch.from_json(resume)
    for field, own, wanted in (
        ("digest", branch.digest, system.digest), ("mode", branch.mode, mode), ("method", branch.method, method),
    ):  # fmt: skip
        if own != wanted:
            raise ArrayError(
                "resume", own, f"is the {field} of that branch, and {wanted!r} is wanted here",
                "resume it with the scene, mode and method that it was traced with",
            )  # fmt: skip
    if branch.regular < 1 or branch.step <= 0:
        raise ArrayError("resume", branch.regular, "points of that branch are a run's own", "trace it anew")
    return branch

