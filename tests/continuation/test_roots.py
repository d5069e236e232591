"""Zeros from few values: to round-off where a function is smooth, in a bracket whatever it is, and never more calls than halving takes."""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import pairwise

import numpy as np
import pytest

from phichain.continuation import Point, predictors
from phichain.continuation.met.roots import zero_between
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


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_jump_is_found_by_halving(sign: float) -> None:
    asked: list[float] = []

    def jump(x: float) -> float:
        asked.append(x)
        return sign if x > 1 / 3 else -sign

    found = zero_between(jump, 0.0, 1.0, (-sign, sign), 1e-12)
    assert abs(found - 1 / 3) < 2e-12 and len(asked) < 4 * 40


def test_an_end_that_vanishes_is_the_zero() -> None:
    assert zero_between(lambda x: x - 1, 0.0, 1.0, (-1.0, 0.0), 1e-14) == 1.0


def _helix(s: float) -> Point:
    """A curve of unit speed, curved and twisted."""
    place = np.array([0.6 * np.cos(s), 0.6 * np.sin(s), 0.8 * s])
    slope = np.array([-0.6 * np.sin(s), 0.6 * np.cos(s), 0.8])
    return Point(place, slope, s, np.eye(2, 3), 0.0, 1, (), Extra())


def test_the_quintic_is_of_sixth_order() -> None:
    """Errors across the curve shrink by 2^6 with half the steps, though arclength is summed up from chords."""
    errors = []
    for h in (0.4, 0.2):
        points = [_helix(s) for s in (-1.9 * h, -h, 0.0)]
        lengths = np.cumsum([0.0, *(np.linalg.norm(b.y - a.y) for a, b in pairwise(points))])
        points = [Point(p.y, p.tangent, float(s), p.jacobian, 0.0, 1, (), p.extra) for p, s in zip(points, lengths, strict=True)]
        off, ahead = predictors.quintic(points, h) - _helix(h).y, _helix(h).tangent
        errors.append(float(np.linalg.norm(off - (off @ ahead) * ahead)))
    assert errors[1] < 1e-5 and errors[0] / errors[1] > 2**5.2, errors
