"""Two zeros of a test function within one step, which its signs at the points do not show: a least value that
lies beyond zero."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from phichain.continuation.engine import Engine
from phichain.continuation.events import Quantity, TestFunction
from phichain.continuation.met.locate import curve, root
from phichain.continuation.met.specials import Special
from phichain.continuation.point import Point
from phichain.continuation.problem import Problem

_ROUNDS: Final = 10
"""Parabolas through three places that are tried on the way down."""
_HALVES: Final = 30
"""Halves of a step in which two zeros are looked for that are known to be there: closer ones are one to round-off."""
_FLAT: Final = 1e-3
"""Share of the places' distance below which the next one is none."""


def pairs_of(
    problem: Problem,
    near: Sequence[Point],
    tests: Sequence[TestFunction],
    values: Sequence[Sequence[float]],
    engine: Engine,
    index: int,
    known: Sequence[Special] = (),
) -> list[Special]:
    """The zeros, two by two, between three successive points of functions that are least at the middle one
    and have one sign at all.

    Args:
        problem: What is continued.
        near: The three points.
        tests: Test functions.
        values: Theirs at the points.
        engine: Corrector and options.
        index: Index of the first of the points in its branch.
        known: Events that were found already: where one of a function lies between the points nothing more is looked for.
    """
    found = []
    for k, test in enumerate(tests):
        if not (isinstance(test, Quantity) and test.in_pairs):
            continue
        if any(event.kind == test.name and event.index >= index for event in known):
            continue
        three = [float(row[k]) for row in values]
        sizes = np.abs(three)
        beyond = _passed(problem, near[1], near[2], test, engine) if three[1] * three[2] > 0 else []
        if not beyond and len({np.sign(value) for value in three}) == 1 and sizes[0] > sizes[1] <= sizes[2]:
            beyond = _beyond(problem, near, test, three, engine)
        for a, b in beyond:
            at = root(problem, a, b, test, engine)
            before = index if at.arclength < near[1].arclength else index + 1
            found.append(Special(test.name, before, at.z(problem), at.arclength, test.value(problem, at), at.multipliers))
    return found


def _passed(problem: Problem, a: Point, b: Point, test: Quantity, engine: Engine) -> list[tuple[Point, Point]]:
    """Two brackets of zeros beside a place of the other sign, where the order of labels changes; none where it does not."""
    if test.order is None:
        return []
    first, last, sign = test.order(a), test.order(b), np.sign(test.of(a))
    if first is None or last is None or len(first) != len(last) or first == last:
        return []
    between = curve(problem, a, b, engine)
    for _ in range(_HALVES):
        middle = between((a.arclength + b.arclength) / 2)
        if sign * test.of(middle) < 0:
            return [(a, middle), (middle, b)]
        found = test.order(middle)
        if found == first:
            a = middle
        elif found == last:
            b = middle
        else:
            return []
    return []


def _beyond(
    problem: Problem, near: Sequence[Point], test: Quantity, values: Sequence[float], engine: Engine
) -> list[tuple[Point, Point]]:
    """Two brackets of zeros beside a place of the other sign; none where there is no such place."""
    points, sign = list(near), np.sign(values[0])
    heights = [sign * value for value in values]
    for _ in range(_ROUNDS):
        places = np.array([point.arclength for point in points])
        _, slope, bend = np.polynomial.polynomial.polyfit(places - places[1], heights, 2)
        least = places[1] - slope / (2 * bend) if bend > 0 else places[1]
        gap = _FLAT * (places[2] - places[0])
        if min(abs(places - least)) < gap:
            # The longer half has not been looked at.
            left = places[1] - places[0] > places[2] - places[1]
            least = places[1] - 2 * gap if left else places[1] + 2 * gap
        a, b = (near[0], near[1]) if least < near[1].arclength else (near[1], near[2])
        new = curve(problem, a, b, engine)(float(least))
        height = sign * test.of(new)
        k = int(np.searchsorted(places, least))
        if height < 0:
            return [(points[k - 1], new), (new, points[k])]
        points.insert(k, new)
        heights.insert(k, height)
        at = int(np.clip(np.argmin(heights), 1, 2))
        points, heights = points[at - 1 : at + 2], heights[at - 1 : at + 2]
    return []
