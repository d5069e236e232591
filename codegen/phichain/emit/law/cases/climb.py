"""The table of a law along a family, and its test vectors: one call each, by the formula in 60 digits.

The law's Programs take no part: the cubic of Catmull and Rom stands here in Hermite's form, and what rounding may do to a result is what
a relative change of every number that goes in does to it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, Final

from mpmath import mp, mpf

from phichain.emit.law.cases.state import DIGITS, EPSILON, as_fraction, fitting, share, turned
from phichain.ir.rounded import nearest
from phichain.laws import FamilyLaw
from phichain.laws.family import FOLLOW, REST, SLIP, SOFT

_ROUNDINGS: Final = 32
"""Roundings that one number takes part in."""

_PLACES: Final = (
    (Fraction(1, 3), Fraction(1, 16)), (Fraction(1, 3), Fraction(31, 32)), (Fraction(5, 4), Fraction(3, 8)), (Fraction(1, 2), Fraction(31, 32)),
    (Fraction(1, 2), Fraction(1, 2)),
)  # fmt: skip
"""Rungs, the first two the lowest and the others in halves of the table, and phases, none on a node."""


@dataclass(frozen=True)
class Case:
    """One call.

    Attributes:
        before: the phase before.
        after: the phase after.
        numbers: rung, at and side before, x_meas, then u, rung and at after, then how far off these may be.
    """

    before: str
    after: str
    numbers: tuple[float, ...]


def table(law: FamilyLaw, real: str) -> list[list[list[float]]]:
    """Every rung by its nodes (x_r, r, K), with a mirrored node before the first and one behind the last; numbers of the type.

    Raises:
        EmissionError: a number does not fit the type.
    """
    rungs = []
    for states, rates, gains in zip(law.states.tolist(), law.rates.tolist(), law.gains.tolist(), strict=True):
        nodes = [[fitting(real, value) for value in (*x, rate, *K)] for x, rate, K in zip(states, rates, gains, strict=True)]
        nx = len(states[0])

        def mirrored(node: Sequence[float], nx: int = nx) -> list[float]:
            return [*(-value for value in node[:nx]), *node[nx:]]

        rungs.append([mirrored(nodes[-2]), *nodes, mirrored(nodes[1])])
    return rungs


def cases(law: FamilyLaw, real: str) -> tuple[Case, ...]:
    """Calls on several rungs and phases of both halves, beside the orbit; one far from it, one about hanging, two about the target."""
    rungs, nodes = table(law, real), law.states.shape[1]
    top = len(rungs) - 1
    found = []
    with mp.workdps(DIGITS):
        for number, (rung, at) in enumerate(_PLACES):
            h = rung if number < 2 else min(rung * top / 2, top - Fraction(1, 4))
            place = (Fraction(int(at * (nodes - 1))) + Fraction(5, 16)) / (nodes - 1)
            found.append(_climbing(law, real, rungs, nearest(real, h), nearest(real, place), 1 - 2 * (number % 2), number))
        half = len(law.catch.target) // 2
        far = [nearest(real, (Fraction(5, 4) if i < half else Fraction(64)) * (-1) ** i) for i in range(2 * half)]
        found.append(_away(law, real, "CLIMBING", far, (nearest(real, Fraction(top, 2)), nearest(real, Fraction(1, 4)), 1.0)))
        found.append(_away(law, real, "CALMING", far, (0.0, 0.0, 1.0)))
        for number in (0, 1):
            scale = Fraction(1, 2 + 6 * number) / Fraction(max(abs(value) for row in law.shape.tolist() for value in row)) / len(far)
            near = [nearest(real, Fraction(t) + scale * share(i, number)) for i, t in enumerate(law.catch.target)]
            found.append(_held(law, real, near))
    return tuple(found)


def _climbing(law: FamilyLaw, real: str, rungs: Any, rung: float, at: float, side: int, number: int) -> Case:
    """A call a few hundredths of the tube beside the orbit."""
    top, nodes, nx = len(rungs) - 1, law.states.shape[1], len(law.catch.target)
    low, node = min(int(rung), top - 1), int(Fraction(at) * (nodes - 1))
    f, g = mpf(rung) - low, mpf(at) * (nodes - 1) - node
    rows = [value for k in (low, low + 1) for row in rungs[k][node : node + 4] for value in row]
    wanted = _blend(rows, f, g, nodes - 1, 2 * nx + 1)[0]
    slow = [nearest(real, Fraction(float(value))) for value in law.slowness[low : low + 2]]
    size = [Fraction(law.tube) / 64 * (1 if 2 * i < nx else Fraction(1 / slow[0] ** 0.5)) for i in range(nx)]
    x = [nearest(real, side * as_fraction(value) + size[i] * share(i, number)) for i, value in enumerate(wanted[:nx])]

    def call(given: Sequence[Any]) -> tuple[Any, Any, Any]:
        return _call(law, given[:nx], given[nx:-4], given[-4:-2], given[-2], given[-1], side, nodes, float(law.rises[low]))

    given = [mpf(value) for value in (*x, *rows, *slow)] + [f, g]
    spread = [mpf(1)] * (len(given) - 2) + [(rung or 1) / f if f else mpf(0), nodes / g]
    values, allowed = _conditioned(call, given, spread, real)
    u, step, ahead = values
    raised = min(max(mpf(rung) + step, mpf(0)), mpf(top))
    moved = mpf(at) + ahead
    moved = moved - 1 if moved >= 1 else moved + 1 if moved < 0 else moved
    unit = _unit(real)
    slack = (allowed[0], allowed[1] + 4 * unit * (rung + 1), allowed[2] + 4 * unit)
    numbers = (rung, at, float(side), *x, *(nearest(real, as_fraction(value)) for value in (u, raised, moved, *slack)))
    return Case("CLIMBING", "CLIMBING", numbers)


def _call(
    law: FamilyLaw, x: Sequence[Any], rows: Sequence[Any], slow: Sequence[Any], f: Any, g: Any, side: int, nodes: int, rise: float
) -> tuple[Any, Any, Any]:
    """u, and by how much rung and phase move."""
    nx, limit, sample = len(x), mpf(law.limit), mpf(law.catch.sample)
    wanted, along = _blend(rows, f, g, nodes - 1, 2 * nx + 1)
    weights = [1 if 2 * i < nx else (1 - f) * slow[0] + f * slow[1] for i in range(nx)]
    away = [turned(side * value - at, turns) for value, at, turns in zip(x, wanted[:nx], law.catch.wraps, strict=True)]
    speed = mp.fsum(weight * d * d for weight, d in zip(weights, along[:nx], strict=True))
    slip = mp.fsum(weight * d * e for weight, d, e in zip(weights, along[:nx], away, strict=True)) / (speed + mpf(SOFT))
    slip = min(max(slip, -mpf(SLIP)), mpf(SLIP))
    across = [e - slip * d for e, d in zip(away, along[:nx], strict=True)]
    push = -mp.fsum(k * e for k, e in zip(wanted[nx + 1 :], across, strict=True))
    step = sample * min(mpf(law.pace), mpf(rise) * wanted[nx]) * max(mpf(-1) / 2, 1 - abs(push) / limit)
    return side * min(max(push, -limit), limit), step, sample * wanted[nx] + mpf(FOLLOW) * slip


def _blend(rows: Sequence[Any], f: Any, g: Any, intervals: int, width: int) -> tuple[list[Any], list[Any]]:
    """The node between, and its derivative by the phase: Hermite's cubic whose slopes are half the way from neighbour to neighbour."""
    values, slopes = [], []
    for i in range(width):
        a, b, c, d = ((1 - f) * mpf(rows[k * width + i]) + f * mpf(rows[(4 + k) * width + i]) for k in range(4))
        left, right = (c - a) / 2, (d - b) / 2
        values.append((1 + 2 * g) * (1 - g) ** 2 * b + g * (1 - g) ** 2 * left + g**2 * (3 - 2 * g) * c + g**2 * (g - 1) * right)
        slope = (6 * g**2 - 6 * g) * (b - c) + (3 * g**2 - 4 * g + 1) * left + (3 * g**2 - 2 * g) * right
        slopes.append(intervals * slope)
    return values, slopes


def _away(law: FamilyLaw, real: str, before: str, x: Sequence[float], state: tuple[float, float, float]) -> Case:
    """A call where the chain is calmed."""
    from phichain.lowering.climb import driven

    assert sum(Fraction(w) * Fraction(v) ** 2 for w, v in zip(law.weights.tolist(), x, strict=True)) > Fraction(REST)
    rate = mpf(x[driven(law)])
    slow = mpf(0.1 / float(law.weights[-1]) ** 0.5)
    u = -mpf(law.limit) * rate / (abs(rate) + slow)
    allowed = _ROUNDINGS * _unit(real) * abs(u)
    numbers = (*state, *x, nearest(real, as_fraction(u)), *state[:2], nearest(real, as_fraction(allowed)), 0.0, 0.0)
    return Case(before, "CALMING", numbers)


def _held(law: FamilyLaw, real: str, x: Sequence[float]) -> Case:
    """A call near the target."""
    catch, nx = law.catch, len(x)

    def call(given: Sequence[Any]) -> tuple[Any]:
        away = [turned(value - target, turns) for value, target, turns in zip(given[:nx], given[nx:], catch.wraps, strict=True)]
        return (mpf(catch.rest[0]) - mp.fsum(mpf(k) * e for k, e in zip(catch.gains[0], away, strict=True)),)

    given = [mpf(value) for value in (*x, *catch.target)]
    (u,), (allowed,) = _conditioned(call, given, [mpf(1)] * len(given), real)
    allowed += _ROUNDINGS * _unit(real) * mp.fsum(abs(mpf(k) * (a - b)) for k, a, b in zip(catch.gains[0], given[:nx], given[nx:], strict=True))
    u = min(max(u, -mpf(law.limit)), mpf(law.limit))
    numbers = (0.0, 0.0, 1.0, *x, nearest(real, as_fraction(u)), 0.0, 0.0, nearest(real, as_fraction(allowed)), 0.0, 0.0)
    return Case("CALMING", "HOLDING", numbers)


def _conditioned(call: Callable[[Sequence[Any]], Any], given: Sequence[Any], spread: Sequence[Any], real: str) -> tuple[Any, list[Any]]:
    """Results, and what roundings of all that goes in may do to them."""
    values, tiny = call(given), mpf(10) ** -(DIGITS // 3)
    total = [mpf(0)] * len(values)
    for k, number in enumerate(given):
        if number:
            moved = call([*given[:k], number * (1 + tiny), *given[k + 1 :]])
            total = [sum_ + abs(new - old) / tiny * spread[k] for sum_, new, old in zip(total, moved, values, strict=True)]
    return values, [_ROUNDINGS * _unit(real) * (sum_ + abs(value)) for sum_, value in zip(total, values, strict=True)]



def _unit(real: str) -> Any:
    return mpf(EPSILON[real].numerator) / EPSILON[real].denominator
