"""Zeros of a test function within one step that its signs at the points do not show: they come two by two, besides those that are known.

Divided by its distances from the zeros that are known a function is as smooth as before, has the others, and one sign at both points if
they are even in number, as they are. So one search for two serves, again and again, however many there are.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Final

from phichain.continuation.engine import Engine
from phichain.continuation.events import BranchPoint, Quantity, TestFunction
from phichain.continuation.met.between import Curve, curve
from phichain.continuation.met.dips import Known, dip_between, may_dip
from phichain.continuation.met.locate import Rows, way_between, zero_of
from phichain.continuation.met.roots import zero_between
from phichain.continuation.met.specials import Special
from phichain.continuation.point import Point
from phichain.continuation.problem import Problem

ROUNDS: Final = 16
"""Searches of one function in one step: one that goes on finding zeros is rounding there, or nothing that a run with such steps could follow."""
_HALVES: Final = 30
"""Halves of a step in which two zeros are looked for that are known to be there: closer ones are one to round-off."""
_OTHERS: Final = 8
"""The same where labels come or go."""
_TOUCHING: Final = 1e-9
"""Distance of two zeros, in units of 1 + s, below which the function only touches zero as far as rounding tells."""
_ROUGH: Final = 1e-3
"""How well a zero between others is known before it is located, in its distance from them."""


@dataclass(frozen=True)
class _Divided:
    """A test function divided by its distances from some of its zeros.

    Attributes:
        test: The function.
        zeros: Their arclengths.
        size: The distance that counts as one.
    """

    test: TestFunction
    zeros: tuple[float, ...]
    size: float

    @property
    def name(self) -> str:
        return self.test.name

    @property
    def terminal(self) -> bool:
        return self.test.terminal

    def value(self, problem: Problem, point: Point) -> float:
        return self.of(point, self.test.value(problem, point))

    def of(self, point: Point, value: float) -> float:
        """What a value at a point becomes; NaN at one of the zeros."""
        product = math.prod((point.arclength - zero) / self.size for zero in self.zeros)
        return value / product if product else math.nan


def pairs_of(
    problem: Problem, tests: Sequence[TestFunction], rows: Rows, step: int, engine: Engine, index: int, met: Sequence[Special] = (),
) -> list[Special]:  # fmt: skip
    """The zeros between two of some points besides those that are known.

    Args:
        problem: What is continued.
        tests: Test functions.
        rows: Successive points of the curve, with theirs.
        step: It is looked between this one of them and the next one.
        engine: Corrector and options.
        index: Index of that point in its branch.
        met: Zeros that are known.
    """
    (a, before), (b, after) = rows[step : step + 2]
    asked: list[tuple[TestFunction, int, tuple[float, ...], _Labels]] = []
    for k, test in enumerate(tests):
        zeros = tuple(event.arclength for event in met if event.kind == test.name and a.arclength < event.arclength < b.arclength)
        labels = _exchanged(test, a, b) if before[k] * after[k] > 0 and not zeros else None
        if labels or may_dip(problem, *_without(test, zeros, rows, k, step), step):
            asked.append((test, k, zeros, labels))
    if not asked:
        return []
    singular = [test for k, test in enumerate(tests) if isinstance(test, BranchPoint) and before[k] * after[k] < 0]
    # What a correction that is trusted leaves of a function may be more than its height.
    earlier = [point for point, _ in rows[:step]]
    between = way_between(problem, a, b, singular, engine, earlier) if singular else curve(problem, a, b, engine, earlier)
    found: list[Special] = []
    for test, k, zeros, labels in asked:
        near = _TOUCHING * (1 + b.arclength)
        for _ in range(ROUNDS):
            divided, known = _without(test, zeros, rows, k, step)
            brackets = _passed(test, a, b, before[k], labels, between) if labels else []
            brackets = brackets or dip_between(problem, divided, known, step, between)
            if zeros:
                brackets = [own for bracket in brackets if (own := _apart(problem, divided, bracket, between, near)) is not None]
                # What is left of a function beside a zero that is known is rounding, where it is flat: of two one alone is none.
                brackets = brackets if len(brackets) % 2 == 0 else []
            both = [zero_of(problem, low, high, test, engine) for low, high in brackets]
            kept = [
                pair for pair in zip(both[::2], both[1::2], strict=True)
                if min(abs(one - other) for one, other in combinations((*zeros, *(at.arclength for at, _ in pair)), 2)) > near
            ]  # fmt: skip
            if not kept:
                break
            found += [Special(test.name, index, at.z(problem), at.arclength, left, at.multipliers) for pair in kept for at, left in pair]
            zeros, labels = (*zeros, *(at.arclength for pair in kept for at, _ in pair)), None
            if not may_dip(problem, *_without(test, zeros, rows, k, step), step):
                break
    return found


_Labels = tuple[tuple[int, ...], tuple[int, ...]] | None


def _without(test: TestFunction, zeros: tuple[float, ...], rows: Rows, k: int, step: int) -> tuple[TestFunction, Known]:
    """A function without some of its zeros, and its values at some points."""
    known = [(point, row[k]) for point, row in rows]
    if not zeros:
        return test, known
    divided = _Divided(test, zeros, rows[step + 1][0].arclength - rows[step][0].arclength)
    return divided, [(point, divided.of(point, value)) for point, value in known]


def _apart(problem: Problem, divided: TestFunction, bracket: tuple[Point, Point], between: Curve, least: float) -> tuple[Point, Point] | None:
    """A bracket of a zero that has no other ones in it; None where it is no farther than `least` from one that is known."""
    assert isinstance(divided, _Divided)
    low, high = bracket
    ends = divided.value(problem, low), divided.value(problem, high)
    apart = high.arclength - low.arclength
    for _ in range(_HALVES):
        place = zero_between(lambda s: divided.value(problem, between(s)), low.arclength, high.arclength, ends, _ROUGH * apart)
        nearest = min(abs(place - zero) for zero in divided.zeros)
        if nearest <= least:
            return None
        if apart <= nearest:
            break
        apart = nearest
    half = min(apart, nearest) / 2
    return between(max(low.arclength, place - half)), between(min(high.arclength, place + half))


def _exchanged(test: TestFunction, a: Point, b: Point) -> _Labels:
    """The labels of both points where they differ; None where they do not."""
    if not isinstance(test, Quantity) or test.order is None:
        return None
    first, last = test.order(a), test.order(b)
    if first is None or last is None or first == last:
        return None
    return first, last


def _passed(test: TestFunction, a: Point, b: Point, value: float, labels: _Labels, between: Curve, depth: int = 0) -> list[tuple[Point, Point]]:
    """Two brackets of zeros beside each place of the other sign where the order of labels changes; none where there is none.

    Labels that are others at both ends, as where one comes or goes, are divided only until those that pass each other lie apart from that.
    """
    if labels is None or depth == (_HALVES if sorted(labels[0]) == sorted(labels[1]) else _OTHERS):
        return []
    assert isinstance(test, Quantity)
    middle = between((a.arclength + b.arclength) / 2)
    if value * test.of(middle) < 0:
        return [(a, middle), (middle, b)]
    return [
        bracket for low, high in ((a, middle), (middle, b))
        for bracket in _passed(test, low, high, value, _exchanged(test, low, high), between, depth + 1)
    ]  # fmt: skip
