"""The next points of a run: one by one, or as many at once as a compiled problem finds without anything on the way."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from phichain.continuation import correctors, predictors
from phichain.continuation.compiled.protocol import Met, Seen, Watch
from phichain.continuation.engine import Engine
from phichain.continuation.events import SINGULAR, BranchPoint, TestFunction, watch_of
from phichain.continuation.met.locate import way_through
from phichain.continuation.met.passage import is_crossed_smoothly
from phichain.continuation.met.singular import Through
from phichain.continuation.met.specials import Special
from phichain.continuation.point import Point
from phichain.continuation.problem import Problem
from phichain.continuation.steps import StepTooSmallError, advance

Values = tuple[float, ...]
_BESIDE = 3
"""Points before a step that help to know the curve in it."""
_ZEROS = 8
"""Zeros in one step from which on it is looked at by itself what lies between them."""


class Stride(NamedTuple):
    """A step that was taken.

    Attributes:
        point: Where it led.
        step: The step to try behind it.
        values: The test functions there, None where nobody has asked; NaN of those that a compiled problem does not know.
        is_plain: Whether it is known that no test function vanishes before it but at what was met, that no gap lies there, and not the start of the run.
        met: Zeros of test functions before it, where it is plain.
        is_clear: Whether it is known that the step before has no zeros but those that signs show.
        through: The curve before it where [J; t] is singular there, if that has been looked into.
    """

    point: Point
    step: float
    values: Values | None = None
    is_plain: bool = False
    met: Sequence[Met] = ()
    is_clear: bool = False
    through: Through | None = None


class Behind(NamedTuple):
    """What a run has behind it.

    Attributes:
        points: Its last points, newest last.
        sigmas: The smallest singular values of [J; t] there.
        values: The test functions at the last ones that are on the same branch.
        step: The step to try first.
        since: Points on this branch.
        start: The first of these.
        zeros: Zeros of test functions in the last step: which one's, and at what arclength.
    """

    points: Sequence[Point]
    sigmas: Sequence[float]
    values: Sequence[Values]
    step: float
    since: int
    start: Point
    zeros: Sequence[tuple[int, float]] = ()


def strides(problem: Problem, behind: Behind, engine: Engine, watch: Sequence[Watch] | None, most: int) -> list[Stride | BaseException]:
    """The next steps of a run, and behind them what ends it there.

    Args:
        problem: What is continued.
        behind: What the run has behind it.
        engine: Predictor, corrector and options.
        watch: The test functions, as a compiled problem takes them (`watched`); None where it cannot.
        most: How many steps are wanted.

    Raises:
        StepTooSmallError: Even the first needs a step below `step_min`.
        KeyboardInterrupt: Ctrl-C came before it was taken.
    """
    if watch is None or problem.compiled is None or len(behind.zeros) > _ZEROS:
        return [Stride(*advance(problem, behind.points, behind.step, engine))]
    step, last = behind.step, behind.points[-1]
    known = [(point.y, point.tangent) for point in behind.points]
    seen = Seen(known, [point.arclength for point in behind.points], behind.sigmas, behind.values, behind.zeros)
    while True:
        ran = problem.compiled.run(seen, last.jacobian, step, most, engine.options, (behind.since, behind.start.y, behind.start.tangent), watch)
        found = [Stride(row.point, row.step, row.values, True, row.met, True) for row in ran.steps]
        if ran.stopped == "sign":
            *kept, doubtful = found
            same = [*behind.points[-len(behind.values) :], *(stride.point for stride in kept)]
            through, is_smooth = _through(problem, same, doubtful.point, engine, watch)
            if not is_smooth and not is_crossed_smoothly(problem, same[-1], doubtful.point, engine):
                if not kept:
                    step = 0.5 * ran.tried
                    continue
                return [*kept[:-1], kept[-1]._replace(step=0.5 * ran.tried)]
            found[-1] = doubtful._replace(through=through)
        if ran.stopped in ("sign", "met"):
            found[-1] = found[-1]._replace(is_plain=False, is_clear=not ran.is_doubtful)
        ending = {"small": StepTooSmallError, "interrupted": KeyboardInterrupt}.get(ran.stopped)
        if ending is not None and not found:
            raise ending
        return [*found, ending()] if ending is not None else [*found]


def _through(
    problem: Problem, before: Sequence[Point], new: Point, engine: Engine, watch: Sequence[Watch]
) -> tuple[Through | None, bool]:
    """The curve from the last of some points of one branch to a new one where det [J; t] has another sign, None where nobody asks for such places;
    and whether it is seen to go on smoothly there."""
    if not any(test.what == SINGULAR for test in watch):
        return None, False
    *earlier, last = before[-_BESIDE - 1 :]
    return way_through(problem, last, new, BranchPoint(), engine, earlier)


def zeros_in(step: Sequence[Point], tests: Sequence[TestFunction], events: Sequence[Special]) -> list[tuple[int, float]]:
    """Those events that lie between a step's ends, by their test functions: which one's, and at what arclength."""
    low, high = step[0].arclength, step[-1].arclength
    near = [event for event in events if low < event.arclength < high]
    return [(k, event.arclength) for event in near for k, test in enumerate(tests) if test.name == event.kind]


def watched(problem: Problem, tests: Sequence[TestFunction], engine: Engine) -> list[Watch] | None:
    """Test functions as a compiled problem takes them; None where it cannot go on alone, because one that may end the run is none of its own, or the engine is not."""
    compiled = problem.compiled
    own = engine.predictor is predictors.osculating and engine.corrector is correctors.pseudo_arclength
    found = [watch_of(problem, test) for test in tests]
    is_known = all(watch.what or not (test.terminal or getattr(test, "ends", None) is not None) for watch, test in zip(found, tests, strict=True))
    if not all(watch.what for watch in found):
        # Where some are looked at from point to point in any case, so are the others.
        found = [watch._replace(passes=False) for watch in found]
    return found if compiled is not None and own and is_known and compiled.watches(found) else None
