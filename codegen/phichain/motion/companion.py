"""Whether a finished run kept what was asked: a second run, by other means, that has to end in the same state.

Local errors below a tolerance say nothing of what a chaotic motion makes of them, nor of noise that no step size removes.
A run by another method is held against the Taylor flow; the Taylor flow against itself from a start as far off as its own
local errors are, which spreads as those do; what auto took for stiff motions against itself at ten times the tolerance.
Where the two ends lie further apart than what was asked lets expect, the run is doubtful.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Final

import numpy as np

from phichain.errors import PhichainError
from phichain.motion.doubts import doubts
from phichain.motion.ledger import Ledger
from phichain.motion.manifold import project_state
from phichain.motion.path import Path, Segment, StalledError
from phichain.motion.problem import Problem
from phichain.system import Vector, pack

Segments = Callable[[Problem, str, Ledger], Iterator[Segment]]

#: The error a named method may end with, in units of its local tolerance: local errors add up and grow.
GROWTH: Final = 1e4
#: And at most: further off, an end is no answer whatever was asked (relative to the motion).
MOST: Final = 1e-2
#: The same at round-off, where no tolerance was given.
MOST_AT_ROUND_OFF: Final = 1e-6
#: `auto` keeps the tolerance itself; two estimates of one error differ by less than this.
ESTIMATE: Final = 4.0
#: What the Taylor flow's local errors add up to, in units of its tolerance.
TAYLOR_SHARE: Final = 1 / 32
#: In fewer steps than this of the Taylor flow, a motion does not make an error of its round-off.
SHORT: Final = 64
#: Steps of the Taylor flow that one of another method is worth in time, and some for the start.
BUDGET: Final = (10, 1000)
#: Times the tolerance at which an implicit run is done once more.
LOOSER: Final = 10.0
ROUND_OFF: Final = float(np.finfo(float).eps)
#: Methods whose errors are relative to the motion.
MEASURED_BY_MOTION: Final = ("taylor", "rosenbrock")
#: Methods that auto takes for stiff motions.
STIFF: Final = ("rosenbrock", "cvodes", "Radau", "BDF")


def reasons_to_doubt(
    problem: Problem, path: Path, name: str, segments: Segments | None, energies: Vector | None, asked: float | None
) -> list[str]:
    """Reasons to doubt a complete run: by its energy, else by a second run; a fixed step (no `segments`) has none of those."""
    found = doubts(problem, path, name, energies)
    return found or ([] if segments is None else departed(problem, path, name, segments, asked))


def departed(problem: Problem, path: Path, name: str, segments: Segments, asked: float | None) -> list[str]:
    """Reasons to doubt a complete run, as sentences; none where no second run is to be had.

    Args:
        problem: What was integrated, with the local tolerance that was kept.
        path: What was found.
        name: The method.
        segments: Its steps.
        asked: The error that `auto` was asked for; None where a method was named or no tolerance given.
    """
    is_held = problem.control is None or problem.held is not None
    if problem.system.real != "double" or not is_held:
        return []
    by, end = _companion(problem, path, name, segments, asked)
    if end is None or not np.isfinite(end).all():
        return []
    apart, scale = _apart(problem, path, end)
    most = _most(problem, name, asked, scale)
    if apart <= most:
        return []
    promised = f"tol {asked:g}" if asked else name
    why = f"{by} ends {apart:.2g} of the motion away, and {most:.2g} is what {promised} promises"
    remedy = "lower tol, shorten the span (errors may grow by themselves), or use the Taylor flow (propagate) at round-off"
    return [f"doubtful: {why}; {remedy}"]


def _most(problem: Problem, name: str, asked: float | None, scale: float) -> float:
    absolute = 0.0 if name in MEASURED_BY_MOTION else problem.atol / scale
    if asked is not None:
        factor = ESTIMATE if name in MEASURED_BY_MOTION else LOOSER
        return factor * (max(asked, LOOSER * problem.tol) + LOOSER * absolute)
    if problem.tol <= ROUND_OFF:
        return MOST_AT_ROUND_OFF
    return min(GROWTH * (problem.tol + absolute), MOST)


def _companion(
    problem: Problem, path: Path, name: str, segments: Segments, asked: float | None
) -> tuple[str, Vector | None]:
    system, x0 = problem.system, problem.x0
    if name == "taylor":
        if path.steps <= SHORT:
            return "", None
        beside = _nudged(problem, max(TAYLOR_SHARE * problem.tol, 2 * ROUND_OFF))
        return "the same from a start as far off as its local errors", _flown(
            problem, "propagate", beside, problem.tol, 2 * path.steps
        )
    if asked is not None and name in STIFF:
        again = f"{name} at ten times the tolerance"
        if name == "rosenbrock":
            return again, _flown(problem, "propagate_stiff", x0, LOOSER * problem.tol, 2 * path.steps)
        return again, _stepped(
            replace(problem, tol=LOOSER * problem.tol, atol=LOOSER * problem.atol, progress=None),
            name,
            segments,
        )
    if system.has("propagate"):
        each, some = BUDGET
        tol = max(problem.tol / GROWTH, ROUND_OFF)
        return "the Taylor flow", _flown(problem, "propagate", x0, tol, each * path.steps + some)
    return "", None


def _nudged(problem: Problem, size: float) -> Vector:
    """The start, moved by `size` of itself in a direction of no symmetry."""
    system, x = problem.system, problem.x0
    signs = np.cos(1.0 + 2.0 * np.arange(len(x)))
    q, v = x[: system.nq], x[system.nq :]
    reach = max(float(np.max(np.abs(q))), float(np.max(np.abs(v))))
    moved = x + size * reach * signs
    if system.is_planar:
        return moved
    return pack(*project_state(system, moved[: system.nq], moved[system.nq :]))


def _flown(problem: Problem, function: str, x0: Vector, tol: float, budget: int) -> Vector | None:
    """The end of an emitted flow, or None where it does not come there."""
    system, nq = problem.system, problem.system.nq
    given = {} if problem.held is None else {"u": problem.held}
    t0, t1 = float(problem.t[0]), float(problem.t[-1])
    found = system.function(function)(
        x0[:nq], x0[nq:], t0, t1, tol, max_steps=budget, **given, **system.parameters(problem.p)
    )
    return pack(found.q, found.v) if found.outcome == "done" else None


def _stepped(problem: Problem, name: str, segments: Segments) -> Vector | None:
    """The end of a run step by step, or None where it does not come there."""
    end = None
    try:
        for segment in segments(problem, name, Ledger()):
            end = segment.x1 if segment.t1 == problem.t[-1] else None
    except (StalledError, PhichainError):
        return None
    return end


def _apart(problem: Problem, path: Path, end: Vector) -> tuple[float, float]:
    """How far two ends lie apart, of what angles and rates reach on the way (angles of one at most); and that size."""
    nq, last = problem.system.nq, path.x[-1]
    reach = np.max(np.abs(path.x), axis=0)
    angle, rate = float(np.max(reach[:nq])), float(np.max(reach[nq:]))
    angle = min(angle, 1.0) if angle else 1.0
    rate = rate or 1.0
    off = np.abs(end - last)
    return float(max(np.max(off[:nq]) / angle, np.max(off[nq:]) / rate)), min(angle, rate)
