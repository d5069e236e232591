"""The estimated error of a run along its way, and until when the run holds what it was asked."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from phichain.motion.error.measure import LOST, Measure
from phichain.motion.error.rounding import FINEST, held_against_other_steps, rounded
from phichain.motion.error.second import TENFOLD, Method, second_run
from phichain.motion.path import Path
from phichain.motion.problem import Problem
from phichain.records import Held
from phichain.system import System, Vector

#: An estimate is this many times what was found: two runs may be wrong in the same way, in part.
SAFETY: Final = 2.0
#: The error a named method may end with, in units of its local tolerance: local errors add up and grow.
GROWTH: Final = 1e4
#: And at most: further off, a state is no answer whatever was asked (relative to the motion).
MOST: Final = 1e-2
#: The same at round-off, where no tolerance was given.
MOST_AT_ROUND_OFF: Final = 1e-4
#: `auto` keeps the tolerance itself, and its error estimate is no better than this.
KEPT: Final = 4.0
#: Two runs that have parted may be close by chance: how much farther either may be from the motion.
PARTED: Final = 5.0
#: The same for neighbours: how much farther, and how far at least.
TANGENT, ALL = 2.0, 1.0
#: From which error on that is, in units of `LOST`: of one that flies where the motion would be, tangent or not; and where errors are chance, of a tangent.
KNOWN, EARLIER = 8.0, 0.5
#: How far they are apart by then: what the motion winds up by in the time since then, on average, so many times.
WANDERS: Final = 4.0
#: From which part of that error on they come back to what part of it at most, known or by chance: what is left of a large error is the error of a neighbour as much.
STAYS: Final = 0.2
BACK: Final = (0.5, 1.0)
#: Methods whose errors are relative to the motion.
MEASURED_BY_MOTION: Final = ("taylor", "rosenbrock")
ROUND_OFF: Final = {"double": float(np.finfo(float).eps), "float": float(np.finfo(np.float32).eps)}


@dataclass(frozen=True, eq=False)
class Estimate(Held):
    """What is known of the errors of a run.

    Attributes:
        error: Estimated errors (m,) at its times, as `Measure` has them; None where nothing is known.
        holds_until: The last of its times up to which no error is above what was asked lets expect; NaN where nothing is known.
        reasons: Why it is doubtful, as sentences; none where it holds to its end.
    """

    error: Vector | None
    holds_until: float
    reasons: tuple[str, ...] = ()


_REMEDY: Final = "lower tol, shorten the span (errors may grow by themselves), or use the Taylor flow (propagate) at round-off"
NONE: Final = Estimate(None, math.nan)


def estimated(problem: Problem, path: Path, name: str, method: Method, asked: float | None) -> Estimate:
    """The errors of a run, by what flies beside its steps or by a second one.

    `NONE` for laws that sample, which may remember what they were asked, and where no second run comes to the end.

    Args:
        problem: What was integrated, with the local tolerance that was kept.
        path: What was found.
        name: By what.
        method: How that runs.
        asked: The error that `auto` was asked for; None where a method was named or no tolerance given.
    """
    if not problem.can_be_repeated or len(path.t) < 2 or not np.isfinite(path.x).all():
        return NONE
    system, measure = problem.system, Measure.of(problem.system, path.x)
    most = _most(problem, name, method.fixed, asked, float(np.min(1 / measure.weights)))
    lost, least, elapsed = LOST, 0.0, None
    if path.off is not None:
        is_chance = problem.tol <= FINEST and not _rounds_by_rule(system)
        error, by, apart, lost = SAFETY * measure.of_parts(path.off()), "neighbours of its steps", TANGENT, (EARLIER if is_chance else KNOWN) * LOST
        least, elapsed, error = ALL, np.abs(path.t - path.t[0]), np.maximum(error, BACK[is_chance] * np.maximum.accumulate(np.where(error > STAYS * LOST, error, 0.0)))
        if system.links == 1 and problem.tol <= FINEST and np.max(error) > most:  # no chaos, but a separatrix
            error = held_against_other_steps(problem, path, measure, error, ROUND_OFF[system.real])
    elif name == "taylor" and system.real == "double" and problem.tol <= FINEST and not problem.is_moved:
        error, by, apart = rounded(problem, path, measure, most), "what rounding grows to beside it", 1.0
    else:
        beside = second_run(problem, path, name, method, measure)
        if beside is None:
            return NONE
        error, by, apart = np.full(len(path.t), np.inf), beside.by, PARTED
        error[: len(beside.x)] = SAFETY * beside.share * measure(beside.x - path.x[: len(beside.x)])
    error = _no_more(error, measure(path.x), ROUND_OFF[system.real], apart, lost, least, elapsed)
    beyond = np.flatnonzero(error > most)
    if not beyond.size:
        return Estimate(error, float(path.t[-1]))
    until = float(path.t[max(0, beyond[0] - 1)])
    promised = f"tol {asked:g}" if asked else name
    why = f"its estimated error, by {by}, passes {most:.2g} of the motion, what {promised} promises, after t = {until:.6g} s"
    is_finest = name == "taylor" and problem.tol <= ROUND_OFF[system.real]
    remedy = "double precision sees no farther, shorten the span" if is_finest else _REMEDY
    return Estimate(error, until, (f"doubtful: {why} and ends at {error[-1]:.2g}; {remedy}",))


def _rounds_by_rule(system: System) -> bool:
    """Whether neighbours know what rounding does to a step with its sign: in the plane, without dry friction, whose tanh has no pair."""
    return system.is_planar and system.joints.friction is None and system.numbers.cart_friction is None


def _no_more(error: Vector, sizes: Vector, round_off: float, apart: float, lost: float, least: float, elapsed: Vector | None = None) -> Vector:
    """Errors not below the last digit; and not smaller again, but `apart` times as large and `least` at least, once two runs have parted, at errors of `lost`.

    None is larger than what the motion has reached by then; and of neighbours, whose series say nothing any more, than what it winds up by in the time
    `elapsed` since they were last seen together.
    """
    reached = np.maximum.accumulate(np.maximum(sizes, 1.0))
    have_parted = np.maximum.accumulate(error > lost)
    parted = np.where(have_parted, np.maximum(apart * np.maximum.accumulate(error), least), error)
    if elapsed is not None and have_parted[-1]:
        first = max(1, int(np.argmax(have_parted)))
        since = (elapsed[first:] - elapsed[first - 1]) / elapsed[first:]
        reached[first:] = np.minimum(reached[first:], np.maximum(WANDERS * since * reached[first:], least))
    found: Vector = np.maximum(np.minimum(parted, reached), round_off / 2 * sizes)
    return found


def _most(problem: Problem, name: str, fixed: bool, asked: float | None, scale: float) -> float:
    """The largest error that what was asked lets expect."""
    if fixed:
        return MOST
    absolute = 0.0 if name in MEASURED_BY_MOTION else problem.atol / scale
    if asked is not None:
        return min(KEPT * (max(asked, TENFOLD * problem.tol) + TENFOLD * absolute), MOST)
    if name == "taylor" and problem.tol <= ROUND_OFF["double"]:
        return MOST_AT_ROUND_OFF
    return min(GROWTH * (problem.tol + absolute), MOST)
