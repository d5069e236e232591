"""The continuation core: problem x predictor x corrector x tests -> Branch.

From a point y with unit tangent t the predictor steps ahead, the corrector returns to the curve, and the new
tangent is the null vector of the new Jacobian. Nothing refers to a parameter, so folds are points like any other.

A step is repeated at half its size when Newton fails, when the tangent turns by more than `max_angle`, when the
corrector moves further than half the step, or when det [J; t^T] changes sign without passing through zero: each is
how a run leaves its branch for a neighbour. The last one tells an avoided crossing, however narrow (down to about
1e-5 of a step), from a branch point: jumping across it looks perfectly smooth otherwise.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from phichain.continuation.branch import Branch, Special
from phichain.continuation.engine import Engine
from phichain.continuation.events import BranchPoint, Fold, TestFunction
from phichain.continuation.locate import locate
from phichain.continuation.options import Options
from phichain.continuation.passage import is_crossed_smoothly
from phichain.continuation.point import Point, tangent_of
from phichain.continuation.problem import Multipliers, Problem
from phichain.errors import ArrayError, ConvergenceError
from phichain.system import Vector

SHORT = 1e-4
"""Steps below this share of step_max resolve what they cross: a change of the determinant's sign is believed there."""


def start_on(problem: Problem, z: Vector, direction: Vector, engine: Engine, *, fixed: bool = False) -> Point:
    """The first point: Newton from z in the plane through z across `direction`.

    Args:
        problem: What is continued.
        z: A guess (n + 1,).
        direction: Where the branch is to go (n + 1,), in unknowns; its tangent is turned that way.
        engine: Corrector and options.
        fixed: True takes `direction` itself as the plane's normal, so that direction . z is kept; else the tangent
            at the guess is.

    Raises:
        ArrayError: Wrong shapes.
        ConvergenceError: Newton did not converge.
    """
    guess = problem.check(z) / problem.sizes
    along = np.asarray(direction, dtype=float) / problem.sizes
    along = along / np.linalg.norm(along)
    normal = along if fixed else tangent_of(problem.at(guess).jacobian, along)
    found = engine.corrector(problem, guess, normal, engine.options)
    if not found.converged:
        raise ConvergenceError(
            "start",
            np.asarray(z).tolist(),
            f"Newton did not reach the branch in {found.iterations} iterations (relative residual {found.residual:.2g})",
            "start closer to a solution",
            corrections=found.corrections,
        )
    return found.point(along, 0.0)


class StepTooSmallError(Exception):
    """A run needs a step below step_min to go on."""


def walk(problem: Problem, start: Point, engine: Engine) -> Iterator[Point]:
    """The points of a branch, one after the other and without end; `start` comes first.

    Raises:
        StepTooSmallError: The next point needs a step below `step_min`.
    """
    points = [start]
    step = engine.options.step
    yield start
    while True:
        new, step = _advance(problem, points, step, engine)
        points = [points[-1], new]
        yield new


def _advance(problem: Problem, points: Sequence[Point], step: float, engine: Engine) -> tuple[Point, float]:
    """The next point and the step to try after it."""
    options, last = engine.options, points[-1]
    while step >= options.step_min:
        guess = engine.predictor(points, step)
        found = engine.corrector(problem, guess, last.tangent, options)
        if found.converged:
            chord = float(np.linalg.norm(found.y - last.y))
            new = found.point(last.tangent, last.arclength + chord)
            turn = float(np.arccos(np.clip(new.tangent @ last.tangent, -1.0, 1.0)))
            shift = float(np.linalg.norm(found.y - guess))
            is_near = turn <= options.max_angle and shift <= 0.5 * step and chord > 0.1 * step
            is_short = step <= SHORT * options.step_max
            if is_near and (is_short or is_crossed_smoothly(problem, last, new, engine)):
                return new, _next_step(step, turn, found.iterations, options)
        step *= 0.5
    raise StepTooSmallError


def _next_step(step: float, turn: float, iterations: int, options: Options) -> float:
    """Aim at a turn of `aim_angle` per step, which grows with the step, and at few Newton iterations."""
    factor = float(np.clip(options.aim_angle / max(turn, 1e-6), 0.5, 2.0))
    if iterations >= options.max_iterations - 1:
        factor = min(factor, 0.7)
    return float(np.clip(step * factor, options.step_min, options.step_max))


def follow(
    problem: Problem,
    start: Point,
    engine: Engine | None = None,
    tests: Sequence[TestFunction] = (Fold(), BranchPoint()),
    name: str = "branch",
) -> Branch:
    """Follow a branch until a terminal event, its own start, the point limit, or the smallest step.

    Args:
        problem: What is continued.
        start: First point, from `start_on`.
        engine: Predictor, corrector and options.
        tests: Events to locate.
        name: Name of the branch.

    Returns:
        The Branch; its status and reason say why it ended.
    """
    engine = engine or Engine()
    points: list[Point] = []
    specials: list[Special] = []
    status, reason = "points", f"max_points = {engine.options.max_points} reached"
    steps = walk(problem, start, engine)
    try:
        while len(points) < engine.options.max_points:
            points.append(next(steps))
            if len(points) < 2:
                continue
            found, last = locate(problem, points[-2], points[-1], tests, engine, len(points) - 2)
            specials += found
            if last is not None:
                points[-1] = last
                status, reason = "event", f"ended by the event '{found[-1].kind}'"
                break
            if _is_closed(points):
                status, reason = "closed", "the branch came back to its start"
                break
    except StepTooSmallError:
        status, reason = "step", f"a step below step_min = {engine.options.step_min:g} would be needed"
    return _record(problem, points, specials, status, reason, name)


def _is_closed(points: Sequence[Point]) -> bool:
    """True when the last step passed through the start in its direction."""
    start, before, after = points[0], points[-2], points[-1]
    if len(points) < 4 or after.tangent @ start.tangent <= 0:
        return False
    behind, ahead = (start.tangent @ (point.y - start.y) for point in (before, after))
    near = np.linalg.norm(after.y - start.y) <= np.linalg.norm(after.y - before.y) * 1.1
    return bool(behind < 0 <= ahead and near)


def _together(multipliers: Sequence[Multipliers]) -> Multipliers:
    """The multipliers of all points (m, k).

    Raises:
        ArrayError: Not every point has as many.
    """
    counts = sorted({len(own) for own in multipliers})
    if len(counts) > 1:
        raise ArrayError(
            "extra.multipliers", counts, "their number changes along the branch", "give as many at every point"
        )
    return np.array(multipliers)


def _record(
    problem: Problem,
    points: Sequence[Point],
    specials: Sequence[Special],
    status: str,
    reason: str,
    name: str,
) -> Branch:
    unknowns = np.array([point.z(problem) for point in points])
    energy = None if problem.energy is None else np.array([problem.energy(z) for z in unknowns])
    return Branch(
        name=name,
        names=problem.names,
        points=unknowns,
        arclength=np.array([point.arclength for point in points]),
        tangent=np.array([point.slope(problem) for point in points]),
        residual=np.array([point.residual for point in points]),
        iterations=np.array([point.iterations for point in points]),
        scale=problem.sizes,
        energy=energy,
        multipliers=_together([point.multipliers for point in points]),
        events=tuple(specials),
        status=status,
        reason=reason,
    )
