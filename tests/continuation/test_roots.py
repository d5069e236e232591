"""Zeros from few values: to round-off where a function is smooth, in a bracket whatever it is, and never more calls than halving takes."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

from phichain.continuation import Point, predictors
from phichain.continuation.met.roots import foretold, zero_between
from phichain.continuation.osculating import osculating
from phichain.continuation.problem import Extra

SMOOTH: dict[str, tuple[Callable[[float], float], float, float, float, int]] = {
    "cosine": (lambda x: math.cos(x) - x, 0.0, 1.0, 0.7390851332151607, 6),
    "short": (lambda x: math.expm1(x) - 0.05, 0.0, 0.1, math.log(1.05), 5),
    "flat to one side": (lambda x: x**9 - 1e-3, 0.0, 1.2, 1e-3 ** (1 / 9), 14),
    "a step": (lambda x: math.tanh(20 * (x - 0.3)), 0.0, 1.0, 0.3, 14),
}


@pytest.mark.parametrize("name", SMOOTH)
def test_a_smooth_zero_takes_few_values(name: str) -> None:
    of, low, high, exact, most = SMOOTH[name]
    asked: list[float] = []

    def noted(x: float) -> float:
        asked.append(x)
        return of(x)

    found = zero_between(noted, low, high, (of(low), of(high)), 1e-14)
    assert abs(found - exact) < 1e-13
    assert found in asked and len(asked) <= most


@pytest.mark.parametrize("name", SMOOTH)
def test_a_zero_near_to_what_is_known_needs_no_value_of_its_own(name: str) -> None:
    """As good as the other, though the function was never asked there, and at most as many values."""
    of, low, high, exact, most = SMOOTH[name]
    counts = []
    for near in (0.0, 1e-6):
        asked: list[float] = []

        def noted(x: float, asked: list[float] = asked) -> float:
            asked.append(x)
            return of(x)

        found = zero_between(noted, low, high, (of(low), of(high)), 1e-14, near=near)
        counts.append(len(asked))
    assert abs(found - exact) < 1e-13 and counts[1] <= counts[0] <= most
    assert (found in asked) == (counts[1] == counts[0]) and min(abs(x - found) for x in asked) < 1e-6


def test_values_beyond_the_bracket_spare_values_within() -> None:
    of = lambda x: math.expm1(x) - 0.05 + 0.3 * math.sin(3 * x) * x
    counts = []
    for outside in ((), (-0.1, -0.2, -0.3)):
        asked: list[float] = []
        def noted(x: float, asked: list[float] = asked) -> float:
            asked.append(x)
            return of(x)
        found = zero_between(noted, 0.0, 0.1, (of(0.0), of(0.1)), 1e-14, [(x, of(x)) for x in outside])
        counts.append(len(asked))
        assert abs(of(found)) < 1e-15
    assert counts[1] < counts[0] and counts[1] <= 3


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_jump_is_found_by_halving(sign: float) -> None:
    asked: list[float] = []

    def jump(x: float) -> float:
        asked.append(x)
        return sign if x > 1 / 3 else -sign

    found = zero_between(jump, 0.0, 1.0, (-sign, sign), 1e-12)
    assert abs(found - 1 / 3) < 2e-12 and len(asked) < 4 * 40


@pytest.mark.parametrize("spacing", [0.0, 1e-30])
def test_a_search_ends_where_no_number_lies_between(spacing: float) -> None:
    """A pole with no value, as at a zero by which a function is divided that rounding has moved: the bracket ends at two neighbours."""
    asked: list[float] = []

    def pole(x: float) -> float:
        asked.append(x)
        assert len(asked) < 1000
        return math.nan if x == 0.3 else 1 / (x - 0.3)

    assert zero_between(pole, 0.0, 1.0, (-1 / 0.3, 1 / 0.7), spacing) == pytest.approx(0.3, abs=1e-15)


def test_noise_is_not_chased() -> None:
    """Beside a zero in values that are rounding the place is known as well as it will be, however fine it is wanted."""
    rng, asked, zero = np.random.default_rng(3), [], 1 + 2.7e-7

    def noisy(x: float) -> float:
        asked.append(x)
        return (x - zero) * (1 + 3e5 * (x - zero)) + 2e-12 * float(rng.uniform(-1, 1))

    for _ in range(60):
        before = len(asked)
        found = zero_between(noisy, 1.0, 1 + 5e-6, (noisy(1.0), noisy(1 + 5e-6)), 1e-14)
        assert abs(found - zero) < 1e-11 and len(asked) - before <= 16


def test_an_end_that_vanishes_is_the_zero() -> None:
    assert zero_between(lambda x: x - 1, 0.0, 1.0, (-1.0, 0.0), 1e-14) == 1.0


def _helix(s: float) -> Point:
    """A curve of unit speed, curved and twisted."""
    place = np.array([0.6 * np.cos(s), 0.6 * np.sin(s), 0.8 * s])
    slope = np.array([-0.6 * np.sin(s), 0.6 * np.cos(s), 0.8])
    return Point(place, slope, s, np.eye(2, 3), 0.0, 1, (), Extra())


@pytest.mark.parametrize(("count", "least"), [(1, 1.9), (2, 3.8), (3, 5.6), (5, 9.0)])
def test_the_osculating_predictor_is_of_twice_as_many_orders_as_it_has_points(count: int, least: float) -> None:
    """Errors across the curve with half the steps, though arclength is summed up from chords."""
    errors = []
    for h in (0.4, 0.2):
        points = [_helix(-h * (k + 0.1 * k * k)) for k in reversed(range(count))]
        guess = predictors.osculating(points, h)
        # The helix at the same distance along the last tangent.
        axis, s = points[-1].tangent, h
        for _ in range(20):
            there = _helix(s)
            s += (h - axis @ (there.y - points[-1].y)) / (axis @ there.tangent)
        errors.append(float(np.linalg.norm(guess - _helix(s).y)))
    assert math.log2(errors[0] / errors[1]) > least, errors


def test_points_that_all_but_coincide_are_one() -> None:
    """Two points 1e-13 apart say no more than one, and a guess 1e-2 beyond them must not divide by what lies between."""
    near = [_helix(s) for s in (0.0, 1e-13, 0.3)]
    axis = _helix(0.15).tangent
    guess = osculating(near, axis, float(axis @ _helix(0.01).y))
    assert np.linalg.norm(guess - _helix(0.01).y) < 1e-6
    few = osculating([near[0], near[2]], axis, float(axis @ _helix(0.01).y))
    assert guess == pytest.approx(few, abs=1e-12)


def test_a_zero_is_foretold_with_how_far_off_it_may_be() -> None:
    places = [0.0, 0.1, 0.2, 0.35, 0.5]
    place, doubt = foretold([(x, math.cos(x) - 0.9) for x in places])
    assert place == pytest.approx(math.acos(0.9), abs=1e-4) and abs(place - math.acos(0.9)) <= doubt < 1e-2
    assert foretold([(0.0, -1.0), (1.0, 1.0)]) == (0.5, math.inf)
