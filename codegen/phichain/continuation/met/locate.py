"""Locating events between two points of a branch: a bracketed root of each test function along the curve."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache

import numpy as np

from phichain.continuation.engine import Engine
from phichain.continuation.events import BranchPoint, Level, Quantity, TestFunction
from phichain.continuation.met.between import Between, Curve, curve
from phichain.continuation.met.passage import SOLVED, TURNED
from phichain.continuation.met.roots import foretold, zero_between
from phichain.continuation.met.singular import Through, half_width, loosened
from phichain.continuation.met.specials import Special
from phichain.continuation.point import Point, point_at
from phichain.continuation.predictors import hermite_shares
from phichain.continuation.problem import Extra, Problem

Rows = Sequence[tuple[Point, Sequence[float]]]
"""Points in order, with the values of all test functions."""
SPACING = 1e-14
"""How far off a zero may be, in units of 1 + s."""
_ROUGH = 1e-7
"""The same of one that something better follows."""
_CENTRED = 5e-2
"""How far off the centre of the neighbourhood of a singular point may be, in half its width."""
_FORETOLD = 5e-2
"""How far two values that nobody had to ask for may differ for one of them to be that centre at first, likewise."""
_FIRST = 2e-3
"""How far off the zero may be that is to be the centre, likewise."""
_VANISHED = 1e-3
"""What is left of the smallest singular value where it vanishes, in its larger value at the ends."""
_TRUST = 1e-8
"""Corrections that are taken without asking again: what they leave is their square, in units of what the problem bends."""
_SETTLED = 1e-14
"""Corrections after which the Jacobian at the last place of an event is asked for once more."""
_BESIDE = 1e-9
"""How far from a place that is known an event may be for what both are to follow from two such places, in units of 1 + s."""


def values_at(problem: Problem, point: Point, tests: Sequence[TestFunction]) -> tuple[float, ...]:
    """The test functions at a point."""
    return tuple(test.value(problem, point) for test in tests)


def locate(
    problem: Problem,
    a: Point,
    b: Point,
    tests: Sequence[TestFunction],
    engine: Engine,
    index: int,
    ends: tuple[Sequence[float], Sequence[float]] | None = None,
    before: Sequence[tuple[Point, Sequence[float]]] = (),
    through: Through | None = None,
) -> tuple[list[Special], Point | None]:
    """The events between two successive points.

    Places in between are guessed on the polynomial that touches the curve at its points and corrected onto the curve; interpolation
    inside a bracket finds the zero of the test function (`roots`). Where a branch point lies between, the curve near it is the polynomial of `singular.through`.

    Args:
        problem: What is continued.
        a: Earlier point.
        b: Later point.
        tests: Test functions.
        engine: Corrector and options.
        index: Index of `a` in its branch.
        ends: Their values at a and at b, where these are known.
        before: The points before a, in order, with their values there.
        through: The curve between them, where a branch point lies there and `way_through` has told.

    Returns:
        The events in order, none after a terminal one; and the point of the terminal one, or None.
    """
    values = ends or (values_at(problem, a, tests), values_at(problem, b, tests))
    found: list[tuple[Special, Point, bool]] = []
    # A test that starts at zero is not crossed; one that arrives at zero is.
    crossed = [
        (test, after, k) for k, (test, first, after) in enumerate(zip(tests, *values, strict=True))
        if first * after < 0 or (after == 0 and first != 0)
    ]  # fmt: skip
    if not crossed:
        return [], None
    earlier = tuple(point for point, _ in before)
    is_known = through is not None and any(isinstance(test, BranchPoint) for test, _, _ in crossed)
    between = through if through is not None and is_known else way_between(problem, a, b, [test for test, _, _ in crossed], engine, earlier)

    def add(test: TestFunction, at: Point, left: float) -> None:
        special = Special(test.name, index, at.z(problem), at.arclength, left, at.multipliers)
        found.append((special, at, _is_end(problem, test, at)))

    for test, after, k in crossed:
        beyond = [(point.arclength, row[k]) for point, row in before]
        add(test, *((b, after) if after == 0 else _located(problem, a, b, test, between, engine, beyond)))
    for test, low, high in _turned(problem, tests, ((a, values[0]), (b, values[1])), [at for _, at, _ in found]):
        add(test, *zero_of(problem, low, high, test, engine))
    found.sort(key=lambda item: item[0].arclength)
    last = next((k for k, (_, _, terminal) in enumerate(found) if terminal), None)
    if last is None:
        return [special for special, _, _ in found], None
    return [special for special, _, _ in found[: last + 1]], found[last][1]


def _turned(problem: Problem, tests: Sequence[TestFunction], ends: Rows, events: Sequence[Point]) -> list[tuple[TestFunction, Point, Point]]:
    """Brackets of levels that are reached and left again in one step: beside events, where unknowns and energy turn."""
    (a, first), (b, last) = ends
    levels = [(test, k) for k, test in enumerate(tests) if isinstance(test, Level) and first[k] * last[k] > 0]
    brackets: list[tuple[TestFunction, Point, Point]] = []
    for test, k in levels:
        beyond = next((at for at in events if first[k] * test.value(problem, at) < 0), None)
        brackets += [] if beyond is None else [(test, a, beyond), (test, beyond, b)]
    return brackets


def _is_end(problem: Problem, test: TestFunction, at: Point) -> bool:
    """Whether a run ends at a zero of a test function."""
    if isinstance(test, BranchPoint | Quantity) and test.ends is not None:
        return test.ends(problem, at)
    return test.terminal


def way_between(
    problem: Problem, a: Point, b: Point, crossed: Sequence[TestFunction], engine: Engine, earlier: Sequence[Point]
) -> Curve:
    """The curve between two points, whatever lies there."""
    singular = next((test for test in crossed if isinstance(test, BranchPoint)), None)
    return curve(problem, a, b, _trusting(engine), earlier) if singular is None else way_through(problem, a, b, singular, engine, earlier)[0]


def way_through(
    problem: Problem, a: Point, b: Point, test: BranchPoint, engine: Engine, earlier: Sequence[Point]
) -> tuple[Through, bool]:
    """The curve between two points where det [J; t] changes its sign, and whether it is known to vanish there on a curve that goes on smoothly.

    A gap of half width w bends the curve by w^2 / h at a distance h: the polynomial through places at such distances is not resolved where w is 1e-7.
    """
    beside = curve(problem, a, b, loosened(engine), earlier)
    # Close to the place Newton stalls, and a neighbourhood need not be centred better than this.
    spacing = max(_ROUGH, _FIRST * half_width(a, b) / (1 + b.arclength))
    rough, doubt = foretold([(point.arclength, test.value(problem, point)) for point in (*earlier, a, b)])
    if not doubt <= _FORETOLD * half_width(a, b):
        rough = _root(problem, a, b, test, beside, spacing)[0].arclength
    first = Through(problem, rough, beside)
    # Once more from the better centre where the rough one, at which Newton stalls, is off.
    zero, left = _root(problem, a, b, test, first, spacing)
    is_there = first.is_resolved and first.is_inside(zero.arclength) and zero.residual < SOLVED and zero.tangent @ a.tangent >= TURNED
    is_smooth = bool(is_there and abs(left) <= _VANISHED * max(abs(test.value(problem, end)) for end in (a, b)))
    is_centred = abs(zero.arclength - rough) < _CENTRED * half_width(a, b)
    return first if is_centred else Through(problem, zero.arclength, beside), is_smooth


def _located(
    problem: Problem, a: Point, b: Point, test: TestFunction, between: Curve, engine: Engine, beyond: Sequence[tuple[float, float]]
) -> tuple[Point, float]:
    """The zero of a test function, and what is left of it; of a level that can be held only roughly at first, and from there exactly where Newton lands."""
    if isinstance(test, Level) and test.held is not None:
        rough = _root(problem, a, b, test, between, _ROUGH, beyond)[0]
        if (landed := _landed(problem, rough, test, engine)) is not rough:
            return landed, test.value(problem, landed)
    if _is_passed(test):
        at, left = _root(problem, a, b, test, between, SPACING, beyond, _BESIDE)
    else:
        at, left = _root(problem, a, b, test, between if isinstance(test, BranchPoint) else curve(problem, a, b, engine), SPACING, beyond)
    landed = _landed(problem, at, test, engine)
    return (at, left) if landed is at else (landed, test.value(problem, landed))


def _is_passed(test: TestFunction) -> bool:
    """Whether a run goes on beyond a zero, which is smooth: nothing starts again there, and no multipliers meet."""
    return not (test.terminal or getattr(test, "ends", None) is not None or getattr(test, "in_pairs", False))


def _landed(problem: Problem, at: Point, test: TestFunction, engine: Engine) -> Point:
    """The point at which an unknown has the very value that ends the run, where the test says which."""
    if not isinstance(test, Level) or test.held is None:
        return at
    component, value = test.held(at.z(problem))
    guess, normal = at.y.copy(), np.zeros_like(at.y)
    guess[component], normal[component] = value / problem.sizes[component], 1.0
    found = engine.corrector(problem, guess, normal, engine.options)
    # A corrector that keeps to no plane, as Moore and Penrose's, leaves the value that is to be held.
    strayed = abs(found.y[component] - guess[component]) > 1e-12 * (1 + abs(guess[component]))
    if not found.converged or strayed or np.linalg.norm(found.y - at.y) > 1e-6 * (1 + np.linalg.norm(at.y)):
        return at
    exact = found.y.copy()
    exact[component] = guess[component]
    return replace(found.point(at.tangent, at.arclength), y=exact)


def zero_of(problem: Problem, a: Point, b: Point, test: TestFunction, engine: Engine) -> tuple[Point, float]:
    """The point between two of a curve at which a test function vanishes that has two signs at them, and what is left of it."""
    return _located(problem, a, b, test, curve(problem, a, b, _trusting(engine)), engine, ())


def _root(
    problem: Problem, a: Point, b: Point, test: TestFunction, between: Curve, spacing: float = SPACING,
    beyond: Sequence[tuple[float, float]] = (), near: float = 0.0,
) -> tuple[Point, float]:  # fmt: skip
    """The zero of a test function along a curve, and what is left of it there."""
    ends = test.value(problem, a), test.value(problem, b)
    size = 1 + b.arclength
    if isinstance(between, Between | Through) and (a, b) == (between.a, between.b):
        found = between.zero(test, ends, (spacing * size, near * size, spacing < _ROUGH), beyond)
        if found is not None:
            (point, left), (other, before), place = found
            if near:
                place = point.arclength - left * (point.arclength - other.arclength) / (left - before) if left != before else point.arclength
            return (point, left) if place == point.arclength else _moved(a, b, (point, left), (other, before), place)
    seen = {a.arclength: (a, ends[0]), b.arclength: (b, ends[1])}

    def of(s: float) -> float:
        point = between(s)
        seen[s] = point, test.value(problem, point)
        return seen[s][1]

    place = zero_between(of, a.arclength, b.arclength, ends, spacing * size, beyond, near * size)
    best = min(seen, key=lambda s: abs(s - place))
    point, left = seen[best]
    other, before = seen[min((s for s in seen if s != best), key=lambda s: abs(s - best))]
    if spacing < _ROUGH and not (point.is_settled and max(point.corrections[-1:], default=0.0) <= _SETTLED):
        point = _settled(problem, point)
        left = test.value(problem, point)
        if near:
            place = best - left * (best - other.arclength) / (left - before) if left != before else best
    return (point, left) if place == best else _moved(a, b, (point, left), (other, before), place)


def _settled(problem: Problem, point: Point) -> Point:
    """A point with the Jacobian of its own place."""
    return point_at(problem, point.y, point.tangent, point.arclength, point.iterations, settle=True)


def _moved(a: Point, b: Point, known: tuple[Point, float], other: tuple[Point, float], s: float) -> tuple[Point, float]:
    """The point at a place close to a known one, along its tangent, and what else is known by its change from another one: to the second order.

    Args:
        a: One end of the step.
        b: The other.
        known: The known point, and the test function there.
        other: The other, likewise.
        s: The place.
    """
    point, left = known
    share = (s - point.arclength) / (point.arclength - other[0].arclength)
    across = b.y - a.y
    ends = [float(across @ vector) for vector in (a.y, b.y, a.tangent, b.tangent)]
    there, here = hermite_shares(a, b, s), hermite_shares(a, b, point.arclength)
    moved = sum(end * (new - old) for end, new, old in zip(ends, there, here, strict=True)) / float(across @ point.tangent)
    extra, before = point.extra, other[0].multipliers
    if point.multipliers.shape == before.shape:
        extra = Extra(point.multipliers + share * (point.multipliers - before), extra.found)
    return replace(point, y=point.y + moved * point.tangent, arclength=s, extra=extra), left + share * (left - other[1])


@lru_cache
def _trusting(engine: Engine) -> Engine:
    """The engine that takes small corrections as they are, which serves where nothing is singular."""
    return replace(engine, options=replace(engine.options, trust=max(engine.options.trust, _TRUST)))
