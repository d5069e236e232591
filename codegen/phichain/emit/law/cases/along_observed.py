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
from phichain.laws import FORGOTTEN, STILL, TrajectoryLaw

_ORDER: Final = 4
"""The C sums up the cubic in another order, with other roundings of the same sizes."""
_EXPECTED: Final = Fraction(3, 4)
"""What was expected, in shares of how far off the measurement is: some of it was not."""
_STUCK: Final = Fraction(3, 2)
"""Pulls of sensors that are stuck, in shares of what counts as such."""
_HELD: Final = Fraction(3, 4)
"""Those of sensors that are not."""
Row = Sequence[float]


def observed_cases(
    law: TrajectoryLaw, real: str, rows: Sequence[Row], held: Row, places: Sequence[Fraction], scales: Sequence[Fraction]
) -> tuple[Case, ...]:
    """Times before, along and behind the trajectory, each on it and off it; a measurement that ends it, and sensors that are stuck."""
    tests = []
    for number, place in enumerate(places):
        t = nearest(real, place * Fraction(law.duration))
        tests += [_case(law, real, rows, held, t, scale, number) for scale in scales]
    middle, behind = (nearest(real, share * Fraction(law.duration)) for share in (Fraction(1, 2), Fraction(3, 2)))
    # Pulls that are too large, of readings that stay (numbers that are even) and of others that have changed.
    stuck = [_case(law, real, rows, held, t, scales[1], number, _STUCK) for t in (middle, behind) for number in (0, 1)] if held else []
    return (*tests, _case(law, real, rows, held, middle, Fraction(4), 0), *stuck)


def _case(
    law: TrajectoryLaw, real: str, rows: Sequence[Row], held: Row, t: float, scale: Fraction, number: int, pull: Fraction = _HELD
) -> Case:
    assert law.observer is not None
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
        bounds = law.observer.learning.bounds.tolist() if law.observer.learning else []
        learned = [2 * Fraction(bound) * share(i, number + 5) for i, bound in enumerate(bounds)]
        memory = tuple(nearest(real, part) for part in (*(_EXPECTED * part for part in off), *(8 * size * share(i, number + 3) for i in range(nq)), *learned))
        memory = (*memory, *_before(law, real, measured, number, pull))
        away = [turned(Rounded.of(y, exact=True) - at, turns) for y, at, turns in zip(measured, wanted, law.catch.wraps, strict=False)]
        is_lost = mp.fsum(d.value**2 for d, turns in zip(away, law.catch.wraps, strict=False) if turns) > mpf(law.tube) ** 2
        is_lost = is_lost or (isfinite(law.rail) and abs(measured[0]) > nearest(real, Fraction(law.rail)))
        found = [Rounded.of(part, exact=True) for part in memory]
        kept = law.observer.estimated
        u, z, following = _held(law, held, away, found[:kept]) if held and place == len(rows) - 1 else _call(law, pair, f, away, found[:kept])
        still, strain = _pulled(law, measured, memory[kept:], [a - b for a, b in zip(z, found, strict=False)])
        is_lost = is_lost or strain > 1
        phase = "LOST" if is_lost else "SWINGING" if place < len(rows) - 1 else "HOLDING"
        none = [Rounded(mpf(0), mpf(0))] * nu
        values = [*(none if is_lost else u), *following, *still]
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



def _before(law: TrajectoryLaw, real: str, measured: Sequence[float], number: int, pull: Fraction) -> list[float]:
    """What was kept of readings: half of the cases find the same again, and pulls in shares of what counts as stuck."""
    if law.observer is None or law.observer.learning is None:
        return []
    limits = [STILL * Fraction(float(step)) for step in law.observer.learning.steps]
    signs = [(-1) ** (number // 2 + i) if number % 2 else 0 for i in range(law.measured)]
    last = [nearest(real, Fraction(y) + sign * limit) for y, sign, limit in zip(measured, signs, limits, strict=True)]
    # One place at a time comes near to what counts as stuck.
    sizes = [pull if i == number // 2 % law.measured else pull * share(i, number + 7) / 8 for i in range(law.measured)]
    pulls = [size * limit for size, limit in zip([*sizes, *sizes], [*limits, *limits], strict=True)]
    return [*last, *(nearest(real, part) for part in pulls)]


def _pulled(law: TrajectoryLaw, measured: Sequence[float], before: Sequence[float], corrections: list[Rounded]) -> tuple[list[Rounded], Any]:
    """What is kept of readings, and the squares of the pulls in shares of what counts as stuck."""
    if law.observer is None or law.observer.learning is None:
        return [], mpf(0)
    nq, T, none = law.measured, Rounded.of(mpf(law.catch.sample)), Rounded(mpf(0), mpf(0))
    left = Rounded.of(1 - mpf(law.catch.sample) / mpf(FORGOTTEN))
    rates, places, strain = [], [], mpf(0)
    for i, step in enumerate(law.observer.learning.steps):
        stays = measured[i] == before[i]
        rate = left * Rounded.of(before[nq + i], exact=True) + corrections[nq + i]
        rates.append(rate if stays else none)
        places.append(left * Rounded.of(before[2 * nq + i], exact=True) + corrections[i] + T * rate if stays else none)
        strain += (places[i].value / (STILL * mpf(float(step)))) ** 2
    return [*(Rounded.of(y, exact=True) for y in measured), *rates, *places], strain


def _call(
    law: TrajectoryLaw, pair: tuple[Row, Row], f: Rounded, away: list[Rounded], memory: list[Rounded]
) -> tuple[list[Rounded], list[Rounded], list[Rounded]]:
    """(u, z, what the next call expects of z and theta) between two rows of the table."""
    nq, nx, nu, count = law.measured, law.states.shape[1], law.inputs.shape[1], len(memory) - law.states.shape[1]
    starts = _starts("xuKLFGME", (nx, nu, nu * nx, nx * nq, nq * nx, nq * nu, count * nq, nq * count))

    def at(table: str, i: int, j: int = 0, width: int = 1) -> Rounded:
        here, after = (Rounded.of(row[starts[table] + i * width + j]) for row in pair)
        return here + f * (after - here)

    apart = [turned(d - e, turns) for d, e, turns in zip(away, memory, law.catch.wraps, strict=False)]
    z = [memory[i] + total(at("L", i, j, nq) * apart[j] for j in range(nq)) for i in range(nx)]
    bounds = law.observer.learning.bounds.tolist() if law.observer and law.observer.learning else []
    theta = [(memory[nx + k] + total(at("M", k, j, nq) * apart[j] for j in range(nq))).clipped(-bounds[k], bounds[k]) for k in range(count)]
    planned = [at("u", k) for k in range(nu)]
    u = _inputs(law, planned, [[at("K", k, i, nx) for i in range(nx)] for k in range(nu)], z)
    pushed = [a - b for a, b in zip(u, planned, strict=True)]
    gained = [
        total(at("F", i, j, nx) * z[j] for j in range(nx)) + total(at("G", i, k, nu) * pushed[k] for k in range(nu))
        + total(at("E", i, k, count) * theta[k] for k in range(count))
        for i in range(nq)
    ]  # fmt: skip
    return u, z, [*_carried(law, z, gained), *theta]


def _held(
    law: TrajectoryLaw, numbers: Row, away: list[Rounded], memory: list[Rounded]
) -> tuple[list[Rounded], list[Rounded], list[Rounded]]:
    """(u, z, what the next call expects of z and theta) at the target: the chain of the parameters that were found, L_in within half a step, L_out beyond."""
    nq, nx, nu = law.measured, law.states.shape[1], law.inputs.shape[1]
    theta, width = memory[nx:], nx + nu
    starts = _starts("qrKhIOFGB", (nq, nu, nu * nx, nq, nx * nq, nx * nq, nq * nx, nq * nu, len(theta) * nq * width))

    def at(part: str, i: int) -> Rounded:
        return Rounded.of(numbers[starts[part] + i])

    apart = [turned(d - e, turns) for d, e, turns in zip(away, memory, law.catch.wraps, strict=False)]
    halves = [at("h", j) for j in range(nq)]
    within = [_between_halves(e, half) for e, half in zip(apart, halves, strict=True)]
    beyond = [e - c for e, c in zip(apart, within, strict=True)]
    z = [
        memory[i] + total(at("I", i * nq + j) * within[j] for j in range(nq)) + total(at("O", i * nq + j) * beyond[j] for j in range(nq))
        for i in range(nx)
    ]  # fmt: skip
    rest = [at("r", k) for k in range(nu)]
    u = _inputs(law, rest, [[at("K", k * nx + i) for i in range(nx)] for k in range(nu)], z)
    both = [*z, *(a - b for a, b in zip(u, rest, strict=True))]
    nominal = [[at("F", i * nx + j) for j in range(nx)] + [at("G", i * nu + j) for j in range(nu)] for i in range(nq)]
    gained = []
    for i in range(nq):
        bent = [total(error * at("B", (k * nq + i) * width + j) for k, error in enumerate(theta)) for j in range(width)]
        gained.append(total((plain + more) * value for plain, more, value in zip(nominal[i], bent, both, strict=True)))
    return u, z, [*_carried(law, z, gained), *theta]


def _inputs(law: TrajectoryLaw, planned: list[Rounded], gains: list[list[Rounded]], z: list[Rounded]) -> list[Rounded]:
    """u = clip(u_r - K z, low, high)."""
    wanted = [at - total(gain * off for gain, off in zip(row, z, strict=True)) for at, row in zip(planned, gains, strict=True)]
    return [one.clipped(low, high) for one, low, high in zip(wanted, law.catch.low, law.catch.high, strict=True)]


def _carried(law: TrajectoryLaw, z: list[Rounded], gained: list[Rounded]) -> list[Rounded]:
    """z_v' = z_v + what rates gain, z_q' = z_q + T (z_v + z_v') / 2."""
    nq, half = law.measured, Rounded.of(mpf(law.catch.sample) / 2)
    rates = [z[nq + i] + gained[i] for i in range(nq)]
    return [*(z[i] + half * (z[nq + i] + rates[i]) for i in range(nq)), *rates]


def _between_halves(apart: Rounded, half: Rounded) -> Rounded:
    """clip(e, -q/2, q/2); a bound moves no further than what it bounds."""
    value = min(max(apart.value, -half.value), half.value)
    return Rounded(value, apart.error + half.error)


def _starts(names: str, sizes: Sequence[int]) -> dict[str, int]:
    """Where each part begins among numbers that stand one behind the other."""
    return {name: sum(sizes[:k]) for k, name in enumerate(names)}
