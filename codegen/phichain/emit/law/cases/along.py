"""The table of a law along a trajectory, and its test vectors: times and measurements, inputs and phases by the formula in 60 digits.

The law's Program takes no part: what it is compared with is u = clip(u_r - K w(x - x_r), low, high) in mpmath, x_r the cubic in
Hermite's basis, out of the very numbers that the table holds.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import isfinite
from typing import Any, Final

from mpmath import mp, mpf

from phichain.emit.law.cases.state import DIGITS, EPSILON, as_fraction, fitting, share, turned
from phichain.ir.rounded import nearest
from phichain.laws import TrajectoryLaw

_ROUNDINGS: Final = 24
"""Roundings of one term: of the cubic, its rate, the gain between two rows, the deviation, its turns, the product."""

_PLACES: Final = (Fraction(-1, 4), Fraction(0), Fraction(1, 16), Fraction(1, 3), Fraction(5, 8), Fraction(31, 32), Fraction(1025, 1024), Fraction(3))
"""When, in shares of the whole; not at its very end, where rounding decides about the phase."""

_SCALES: Final = (Fraction(0), Fraction(1, 256), Fraction(1, 8))
"""How far from the trajectory measurements lie, in shares of the tube."""


_RATES: Final = 64
"""How much farther off rates are, so that limits are met."""


@dataclass(frozen=True)
class Case:
    """One call.

    Attributes:
        t: the time, a number of the law's type.
        measured: x_meas or y_meas, likewise.
        phase: the phase.
        expected: u, and behind it what an observer expects of the next call; rounded once.
        allowed: how far each of them may be off by rounding alone.
        memory: what the observer expected before, likewise; nothing without one.
    """

    t: float
    measured: tuple[float, ...]
    phase: str
    expected: tuple[float, ...]
    allowed: tuple[float, ...]
    memory: tuple[float, ...] = ()

    @property
    def numbers(self) -> tuple[float, ...]:
        """All of them in the order of the self-test's rows."""
        return (self.t, *self.measured, *self.memory, *self.expected, *self.allowed)


def table(law: TrajectoryLaw, real: str) -> list[list[float]]:
    """One row a knot: x_r, u_r, the gains row by row, and what an observer has; numbers of the type.

    Raises:
        EmissionError: a number does not fit the type.
    """
    parts = [part.reshape(len(part), -1).tolist() for part in law.tables]
    return [[fitting(real, value) for part in row for value in part] for row in zip(*parts, strict=True)]


def held_numbers(law: TrajectoryLaw, real: str) -> list[float]:
    """What the chain is held by where parameters are learned, in the order of `held_sizes`; nothing elsewhere.

    Raises:
        EmissionError: a number does not fit the type.
    """
    seen = law.observer
    if seen is None or seen.learning is None:
        return []
    learning = seen.learning
    parts = (
        law.states[-1, : law.measured], law.inputs[-1], law.gains[-1], learning.steps / 2, learning.inside, learning.outside, seen.flows[-1],
        seen.drives[-1], learning.bends,
    )  # fmt: skip
    return [fitting(real, value) for part in parts for value in part.ravel().tolist()]


def cases(law: TrajectoryLaw, real: str) -> tuple[Case, ...]:
    """Times before, along and behind the trajectory, each on it and off it; and two measurements that end it."""
    if law.observer:
        from phichain.emit.law.cases.along_observed import observed_cases

        return observed_cases(law, real, table(law, real), held_numbers(law, real), _PLACES, _SCALES)
    rows = table(law, real)
    tests = []
    for number, place in enumerate(_PLACES):
        t = nearest(real, place * Fraction(law.duration))
        tests += [_case(law, real, rows, t, scale, number) for scale in _SCALES]
    middle = nearest(real, Fraction(law.duration) / 2)
    tests.append(_case(law, real, rows, middle, Fraction(4), 0))
    return tuple(tests)


def _case(law: TrajectoryLaw, real: str, rows: Sequence[Sequence[float]], t: float, scale: Fraction, number: int) -> Case:
    catch = law.catch
    with mp.workdps(DIGITS):
        place = min(max(mpf(t) / mpf(law.interval), mpf(0)), mpf(len(rows) - 1))
        j = int(place)
        pair = (rows[j], rows[min(j + 1, len(rows) - 1)])
        wanted = _cubic(law, *pair, place - j)
        size = scale * Fraction(law.tube)
        away = [size if scale > 1 else size * share(i, number) * (_RATES if 2 * i >= len(wanted) else 1) / 4 for i in range(len(wanted))]
        measured = tuple(nearest(real, as_fraction(at) + part) for at, part in zip(wanted, away, strict=True))
        off = [turned(mpf(x) - at, turns) for x, at, turns in zip(measured, wanted, catch.wraps, strict=True)]
        is_lost = mp.fsum(d**2 for d, turns in zip(off, catch.wraps, strict=True) if turns) > mpf(law.tube) ** 2
        is_lost = is_lost or (isfinite(law.rail) and abs(measured[0]) > nearest(real, Fraction(law.rail)))
        if is_lost:
            still = (0.0,) * len(catch.low)
            return Case(t, measured, "LOST", still, still)
        found = [_input(law, real, pair, len(rows), place - j, off, measured, k) for k in range(len(catch.low))]
        phase = "SWINGING" if place < len(rows) - 1 else "HOLDING"
        expected = tuple(nearest(real, as_fraction(u)) for u, _ in found)
        allowed = tuple(nearest(real, as_fraction(bound)) for _, bound in found)
    return Case(t, measured, phase, expected, allowed)


def _cubic(law: TrajectoryLaw, here: Sequence[float], after: Sequence[float], f: Any) -> list[Any]:
    """x_r in Hermite's basis: q = h00 q_0 + h10 h v_0 + h01 q_1 + h11 h v_1, and its rate."""
    half, h = law.states.shape[1] // 2, mpf(law.interval)
    values = ((1 + 2 * f) * (1 - f) ** 2, f * (1 - f) ** 2, f**2 * (3 - 2 * f), f**2 * (f - 1))
    slopes = (6 * f**2 - 6 * f, 3 * f**2 - 4 * f + 1, 6 * f - 6 * f**2, 3 * f**2 - 2 * f)
    ends = [[mpf(row[k]) for row in (here, after) for k in (i, half + i)] for i in range(half)]
    places = [values[0] * a + values[1] * h * b + values[2] * c + values[3] * h * d for a, b, c, d in ends]
    rates = [(slopes[0] * a + slopes[2] * c) / h + slopes[1] * b + slopes[3] * d for a, b, c, d in ends]
    return [*places, *rates]



def _input(
    law: TrajectoryLaw, real: str, pair: tuple[Sequence[float], Sequence[float]], knots: int, f: Any, off: Sequence[Any],
    measured: Sequence[float], k: int,
) -> tuple[Any, Any]:  # fmt: skip
    """One input, and what rounding may add to it; the place in the table is known to rounding as well."""
    nx, nu = len(off), len(law.catch.low)
    here, after = pair
    first, second = mpf(here[nx + k]), mpf(after[nx + k])
    u, terms = first + f * (second - first), abs(first) + abs(second) + knots * abs(second - first)
    for i, away in enumerate(off):
        at = nx + nu + k * nx + i
        first, second = mpf(here[at]), mpf(after[at])
        gain = first + f * (second - first)
        u -= gain * away
        terms += abs(away) * (abs(first) + abs(second) + knots * abs(second - first))
        terms += abs(gain) * _reference_terms(law, here, after, i, knots, measured[i])
    unit = mpf(EPSILON[real].numerator) / EPSILON[real].denominator
    low, high = law.catch.low[k], law.catch.high[k]
    u = max(u, mpf(low)) if isfinite(low) else u
    u = min(u, mpf(high)) if isfinite(high) else u
    return u, (_ROUNDINGS + nx) * unit * terms


def _reference_terms(law: TrajectoryLaw, here: Sequence[float], after: Sequence[float], i: int, knots: int, x: float) -> Any:
    """Sizes of what is added up in one entry of x - x_r."""
    half, h = len(law.catch.state_names) // 2, mpf(law.interval)
    at = i % half
    places, rates = abs(mpf(here[at])) + abs(mpf(after[at])), abs(mpf(here[half + at])) + abs(mpf(after[half + at]))
    step = abs(mpf(after[at]) - mpf(here[at])) + h * rates
    if i < half:
        return abs(mpf(x)) + places + knots * step
    # The step of the places is exact as a difference, and known to the rounding of its factor.
    return abs(mpf(x)) + rates + (6 + 6 * knots) * step / h
