"""One step along a curve, no longer than what the Jacobian does on the way allows.

A step is repeated at half its size when Newton fails, when the tangent turns by more than `max_angle`, when the corrector moves
further than half the step, or when the Jacobian changes by more than `max_change` in its own units, those of the eigenvalues of
[J; t]^-1 dJ, which no scaling of equations or unknowns changes. Below 1 the matrix [J; t] cannot have been singular on the way: so
near an avoided crossing steps shrink with the distance from it, and the run turns with its branch. A branch point, where [J; t] is
singular, would be approached for ever; it is stepped over, which changes the sign of det [J; t]. That sign changes too where a step jumped a gap, and then without passing through zero
(`passage.is_crossed_smoothly`): jumping across looks perfectly smooth otherwise.

Source: P. Deuflhard, Newton Methods for Nonlinear Problems, Springer 2004, chapter 5 (affine covariant step control).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from phichain.continuation import correctors, predictors
from phichain.continuation.correctors import Correction
from phichain.continuation.engine import Engine
from phichain.continuation.linear import bordered, eigenvalues, size, solve
from phichain.continuation.met.passage import NARROW, is_crossed_smoothly
from phichain.continuation.options import Options
from phichain.continuation.point import Point
from phichain.continuation.problem import Problem
from phichain.system import Vector

_SEEN = 0.2
"""Changes of the Jacobian below which nothing singular is near."""
_LEAP = 1.8
"""Length of a step over a place where [J; t] vanishes, in distances from it; half of it stays before the place, and is refused."""
_REACH = (4.0, 12.0)
"""How far such a place may be, in steps: while they grow, and where they have begun to shrink on the way to it."""
_LONGER = 2.2
"""Length of a step, in that of the step before, above which it is such a leap: usual ones are at most twice as long as what was tried before."""


class StepTooSmallError(Exception):
    """A run needs a step below step_min to go on."""


def advance(problem: Problem, points: Sequence[Point], step: float, engine: Engine) -> tuple[Point, float]:
    """The next point, and the step to try after it.

    Args:
        problem: What is continued.
        points: The last points, newest last.
        step: The step to try first.
        engine: Predictor, corrector and options.

    Raises:
        StepTooSmallError: It needs a step below `step_min`.
    """
    options, last = engine.options, points[-1]
    while step >= options.step_min:
        tried = _tried(problem, points, step, engine)
        if tried.found.converged:
            turn = math.acos(min(1.0, max(-1.0, tried.turned)))
            is_near = turn <= options.max_angle and tried.shifted <= 0.5 * step and tried.moved > 0.1 * step
            if is_near:
                new = tried.found.point(last.tangent, last.arclength + tried.moved)
                change, is_turned, ahead = change_between(tried.changed, tried.change)
                # The branches beside a gap that is none to be crossed are farther from each other than such a step is long.
                is_short = step <= NARROW
                is_whole = not is_turned and change <= options.max_change and not _is_leap(points, step)
                if is_short or is_whole or (is_turned and is_crossed_smoothly(problem, last, new, engine)):
                    return new, _next_step(step, turn, change, ahead * step, tried.found.iterations, options)
        step *= 0.5
    raise StepTooSmallError


def _is_leap(points: Sequence[Point], step: float) -> bool:
    """Whether a step is one over a place where [J; t] was to vanish, by its length: where no sign changed it leapt over two of them, or over none and unseen."""
    return len(points) > 1 and step > _LONGER * (points[-1].arclength - points[-2].arclength)


class _Tried(NamedTuple):
    """A step that was tried: where it led, how far, how far Newton moved the guess, the cosine of the turn, and how [J; t] changed."""

    found: Correction
    moved: float
    shifted: float
    turned: float
    changed: float
    change: Callable[[], Vector]


def _tried(problem: Problem, points: Sequence[Point], step: float, engine: Engine) -> _Tried:
    """Predict and correct, in one call where the problem has it compiled."""
    options, last = engine.options, points[-1]
    if problem.compiled is not None and engine.predictor is predictors.osculating and engine.corrector is correctors.pseudo_arclength:
        known = [(point.y, point.tangent) for point in points[-predictors.TOUCHED :]]
        way = problem.compiled.ahead(known, last.jacobian, step, options.tol, options.max_iterations)
        return _Tried(Correction.made(**way.told), way.moved, way.shifted, way.turned, way.changed, way.change)
    guess = engine.predictor(points, step)
    found = engine.corrector(problem, guess, last.tangent, options)
    if not found.converged:
        return _Tried(found, 0.0, 0.0, 0.0, 0.0, _nothing)
    new = found.point(last.tangent, 0.0)
    changed, change = _compared(last, new)
    return _Tried(found, size(found.y - last.y), size(found.y - guess), float(new.tangent @ last.tangent), changed, lambda: change)


def _nothing() -> Vector:
    return np.empty((0, 0))


def _compared(a: Point, b: Point) -> tuple[float, Vector]:
    """[J_a; t_a]^-1 [J_b; t_a], behind the size of its difference from 1, infinity where [J_a; t_a] is singular."""
    try:
        step = solve(bordered(a.jacobian, a.tangent), bordered(b.jacobian, a.tangent))
    except np.linalg.LinAlgError:
        return float("inf"), b.jacobian
    moved = step.copy()
    moved.flat[:: len(moved) + 1] -= 1
    return size(moved.ravel()), step


def change_between(change: float, matrix: Callable[[], Vector]) -> tuple[float, bool, float]:
    """How far [J; t] changed from one point a to the next one b.

    Args:
        change: Size of [J_a; t_a]^-1 dJ.
        matrix: [J_a; t_a]^-1 [J_b; t_a].

    Returns:
        The spectral radius of [J_a; t_a]^-1 dJ; whether det [J; t] has another sign at b; and how far beyond b it vanishes, if it goes on as
        from a to b, in distances from a to b, infinity where it does not.
    """
    if change < _SEEN or math.isinf(change):
        return change, False, float("inf")
    left = eigenvalues(matrix()).tolist()
    change = max(abs(value - 1) for value in left)
    # det [J_b; t_a] = det [J_b; t_b] t_a.t_b, and the tangents never turn by a right angle.
    is_turned = math.prod(left).real < 0
    real = [value.real for value in left if abs(value.imag) < 0.1 * abs(1 - value) and 0 < value.real < 1]
    ahead = min(value / (1 - value) for value in real) if real and not is_turned else float("inf")
    return change, is_turned, ahead


def _next_step(step: float, turn: float, change: float, ahead: float, iterations: int, options: Options) -> float:
    """Aim at a turn of `aim_angle` and at half the change that is allowed, both of which grow with the step.

    Where [J; t] is on its way to vanish, steps that halve the distance would never arrive: the next one leaps over the place,
    about as far beyond; if a gap is there instead of a branch point, the leap is refused and the halves go on.
    """
    aims = (options.aim_angle / max(turn, 1e-6), 0.5 * options.max_change / max(change, 1e-6))
    factor = min(2.0, max(0.5, min(aims)))
    if iterations >= options.max_iterations - 1:
        factor = min(factor, 0.7)
    usual = min(options.step_max, max(options.step_min, step * factor))
    leap = _LEAP * ahead
    reach = _REACH[factor < 1] * usual
    return leap if usual < ahead < reach and leap <= options.step_max else usual


def is_closed(start: Point, before: Point, after: Point) -> bool:
    """True when the step from one point to the next passed through the start in its direction."""
    if after.tangent @ start.tangent <= 0:
        return False
    behind, ahead = (start.tangent @ (point.y - start.y) for point in (before, after))
    return bool(behind < 0 <= ahead and np.linalg.norm(after.y - start.y) <= np.linalg.norm(after.y - before.y) * 1.1)
