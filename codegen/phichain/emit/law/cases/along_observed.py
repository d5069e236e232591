"""Test vectors of a law along a trajectory with an observer: inputs, and what the observer expects next, by the formulas in 60 digits.

The law's Program takes no part: what it is compared with is the record's definition in mpmath, x_r the cubic in Hermite's basis, out of
the very numbers that the table holds; each number carries the bound of what rounding may have done to it.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from math import isfinite
from typing import Any, Final

from mpmath import mp, mpf

from phichain.emit.law.cases.along import Case
from phichain.emit.law.cases.rounding import Rounded, total, turned
from phichain.emit.law.cases.state import DIGITS, as_fraction, share
from phichain.ir.rounded import nearest
from phichain.laws import TrajectoryLaw

_ORDER: Final = 4
"""The C sums up the cubic in another order, with other roundings of the same sizes."""
_EXPECTED: Final = Fraction(3, 4)
"""What was expected, in shares of how far off the measurement is: some of it was not."""
Row = Sequence[float]


def observed_cases(law: TrajectoryLaw, real: str, rows: Sequence[Row], places: Sequence[Fraction], scales: Sequence[Fraction]) -> tuple[Case, ...]:
    """Times before, along and behind the trajectory, each on it and off it; and a measurement that ends it."""
    tests = []
    for number, place in enumerate(places):
        t = nearest(real, place * Fraction(law.duration))
        tests += [_case(law, real, rows, t, scale, number) for scale in scales]
    return (*tests, _case(law, real, rows, nearest(real, Fraction(law.duration) / 2), Fraction(4), 0))


def _case(law: TrajectoryLaw, real: str, rows: Sequence[Row], t: float, scale: Fraction, number: int) -> Case:
    nq, nu = law.measured, law.inputs.shape[1]
    with mp.workdps(DIGITS):
        place = min(max(mpf(t) / mpf(law.interval), mpf(0)), mpf(len(rows) - 1))
        j = int(place)
        # t times the rate, rounded, less a whole number.
        f = Rounded(place - j, 2 * place)
        pair = (rows[j], rows[min(j + 1, len(rows) - 1)])
        wanted = _cubic(law, *pair, f)
        size = scale * Fraction(law.tube)
        off = [size if scale > 1 else size * share(i, number) / 4 for i in range(nq)]
        measured = tuple(nearest(real, as_fraction(at.value) + part) for at, part in zip(wanted, off, strict=True))
        memory = tuple(nearest(real, part) for part in (*(_EXPECTED * part for part in off), *(8 * size * share(i, number + 3) for i in range(nq))))
        away = [turned(Rounded.of(y, exact=True) - at, turns) for y, at, turns in zip(measured, wanted, law.catch.wraps, strict=False)]
        is_lost = mp.fsum(d.value**2 for d, turns in zip(away, law.catch.wraps, strict=False) if turns) > mpf(law.tube) ** 2
        is_lost = is_lost or (isfinite(law.rail) and abs(measured[0]) > nearest(real, Fraction(law.rail)))
        u, following = _call(law, pair, f, away, [Rounded.of(part, exact=True) for part in memory])
        phase = "LOST" if is_lost else "SWINGING" if place < len(rows) - 1 else "HOLDING"
        still = [Rounded(mpf(0), mpf(0))] * nu
        values = [*(still if is_lost else u), *following]
        expected = tuple(nearest(real, as_fraction(value.value)) for value in values)
        allowed = tuple(nearest(real, as_fraction(_ORDER * value.allowed(real))) for value in values)
    return Case(t, measured, phase, expected, allowed, memory)


def _cubic(law: TrajectoryLaw, here: Row, after: Row, f: Rounded) -> list[Rounded]:
    """q_r = h00 q_0 + h10 h v_0 + h01 q_1 + h11 h v_1."""
    half, h, one = law.measured, Rounded.of(mpf(law.interval)), Rounded(mpf(1), mpf(0))
    rest, two, three = one - f, one + one, one + one + one
    factors = ((one + two * f) * rest * rest, f * rest * rest * h, f * f * (three - two * f), f * f * (f - one) * h)
    ends = [[Rounded.of(row[k]) for row in (here, after) for k in (i, half + i)] for i in range(half)]
    return [total(factor * end for factor, end in zip(factors, four, strict=True)) for four in ends]



def _call(law: TrajectoryLaw, pair: tuple[Row, Row], f: Rounded, away: list[Rounded], memory: list[Rounded]) -> tuple[list[Rounded], list[Rounded]]:
    """(u, z_expected of the next call)."""
    nq, nx, nu, catch = law.measured, law.states.shape[1], law.inputs.shape[1], law.catch
    starts = dict(zip("uKLFG", _places(nx, nq, nu), strict=True))

    def at(table: str, i: int, j: int = 0, width: int = 1) -> Rounded:
        here, after = (Rounded.of(row[starts[table] + i * width + j]) for row in pair)
        return here + f * (after - here)

    apart = [turned(d - e, turns) for d, e, turns in zip(away, memory, catch.wraps, strict=False)]
    z = [memory[i] + total(at("L", i, j, nq) * apart[j] for j in range(nq)) for i in range(nx)]
    planned = [at("u", k) for k in range(nu)]
    u = [
        (planned[k] - total(at("K", k, i, nx) * z[i] for i in range(nx))).clipped(catch.low[k], catch.high[k]) for k in range(nu)
    ]  # fmt: skip
    pushed = [a - b for a, b in zip(u, planned, strict=True)]
    rates = [
        z[nq + i] + total(at("F", i, j, nx) * z[j] for j in range(nx)) + total(at("G", i, k, nu) * pushed[k] for k in range(nu))
        for i in range(nq)
    ]
    half = Rounded.of(mpf(catch.sample) / 2)
    return u, [*(z[i] + half * (z[nq + i] + rates[i]) for i in range(nq)), *rates]


def _places(nx: int, nq: int, nu: int) -> list[int]:
    """Where u_r, K, L, F and G begin in a row."""
    found: list[Any] = [nx]
    for size in (nu, nu * nx, nx * nq, nq * nx):
        found.append(found[-1] + size)
    return found
