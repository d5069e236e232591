"""Two zeros of a test function within one step, which its signs at the points do not show."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from phichain.continuation.engine import Engine
from phichain.continuation.events import BranchPoint, Quantity, TestFunction
from phichain.continuation.met.dips import dip_between, may_dip
from phichain.continuation.met.locate import Curve, Rows, curve, way_between, zero_of
from phichain.continuation.met.specials import Special
from phichain.continuation.point import Point
from phichain.continuation.problem import Problem

_HALVES: Final = 30
"""Halves of a step in which two zeros are looked for that are known to be there: closer ones are one to round-off."""
_TOUCHING: Final = 1e-9
"""Distance of two zeros, in units of 1 + s, below which the function only touches zero as far as rounding tells."""


def pairs_of(problem: Problem, tests: Sequence[TestFunction], rows: Rows, step: int, engine: Engine, index: int) -> list[Special]:
    """The zeros, two by two, between two of some points, of functions that have one sign at both.

    Args:
        problem: What is continued.
        tests: Test functions.
        rows: Successive points of the curve, with theirs.
        step: It is looked between this one of them and the next one.
        engine: Corrector and options.
        index: Index of that point in its branch.
    """
    (a, before), (b, after) = rows[step : step + 2]
    found: list[Special] = []
    asked = [
        (test, k, labels) for k, test in enumerate(tests)
        if before[k] * after[k] > 0 and ((labels := _exchanged(test, a, b)) or may_dip(problem, test, rows, k, step))
    ]  # fmt: skip
    if not asked:
        return found
    singular = [test for k, test in enumerate(tests) if isinstance(test, BranchPoint) and before[k] * after[k] < 0]
    # What a correction that is trusted leaves of a function may be more than its height.
    earlier = [point for point, _ in rows[:step]]
    between = way_between(problem, a, b, singular, engine, earlier) if singular else curve(problem, a, b, engine, earlier)
    for test, k, labels in asked:
        known = [(point, row[k]) for point, row in rows]
        brackets = _passed(test, a, b, before[k], labels, between) if labels else []
        zeros = [zero_of(problem, low, high, test, engine) for low, high in brackets or dip_between(problem, test, known, step, between)]
        if zeros and zeros[1][0].arclength - zeros[0][0].arclength > _TOUCHING * (1 + b.arclength):
            found += [Special(test.name, index, at.z(problem), at.arclength, left, at.multipliers) for at, left in zeros]
    return found


def _exchanged(test: TestFunction, a: Point, b: Point) -> tuple[tuple[int, ...], tuple[int, ...]] | None:
    """The labels of both points where their order changes; None where it does not."""
    if not isinstance(test, Quantity) or test.order is None:
        return None
    first, last = test.order(a), test.order(b)
    if first is None or last is None or len(first) != len(last) or first == last:
        return None
    return first, last


def _passed(
    test: TestFunction, a: Point, b: Point, value: float, labels: tuple[tuple[int, ...], tuple[int, ...]], between: Curve
) -> list[tuple[Point, Point]]:
    """Two brackets of zeros beside a place of the other sign, where the order of labels changes; none where there is none."""
    assert isinstance(test, Quantity) and test.order is not None
    for _ in range(_HALVES):
        middle = between((a.arclength + b.arclength) / 2)
        if value * test.of(middle) < 0:
            return [(a, middle), (middle, b)]
        found = test.order(middle)
        if found == labels[0]:
            a = middle
        elif found == labels[1]:
            b = middle
        else:
            return []
    return []
