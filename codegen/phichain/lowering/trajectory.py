"""A law along a trajectory -> Programs: what happens between two rows of its table, and how its observer begins."""

from __future__ import annotations

from fractions import Fraction
from math import isfinite

from phichain.ir.builder import Builder, Expr
from phichain.ir.handles import ArrayRef
from phichain.ir.nodes import Program
from phichain.ir.passes import prune
from phichain.ir.piecewise import maximum, minimum, wrapped
from phichain.laws import TrajectoryLaw
from phichain.lowering.laws import full_turn
from phichain.lowering.laws.still import pulled


def tracking(law: TrajectoryLaw) -> Program:
    """`tracking(x_meas, here, next, f) -> u, off`: the law a share f of the way from one row of its table to the next.

    A row is x_r, u_r, K row by row. With d = q_1 - q_0 and h from one row to the next,

        q_r = q_0 + f (h v_0 + f (3 d - h (2 v_0 + v_1) + f (h (v_0 + v_1) - 2 d)))
        v_r = v_0 + f (6 d / h - 4 v_0 - 2 v_1 + f (3 (v_0 + v_1) - 6 d / h))
        u   = clip(u_0 + f (u_1 - u_0) - (K_0 + f (K_1 - K_0)) w(x_meas - x_r), low, high),

    and off the sum of the squares of the angles' deviations. What is not a number spreads into u and off. With an observer it is
    `tracking(y_meas, expected, here, next, f) -> u, off, following`: rows go on with L, F and G, row by row, and x_meas - x_r gives
    way to z = expected + L w(y_meas - q_r - C expected), of which the next call expects what ObserverAlong says. Where it learns
    parameters, rows end with M and E, and theta, kept within its bounds, stands behind z in what is expected; behind it stands what tells a
    sensor that is stuck, which counts in `off` too: see `still`.
    """
    catch, seen = law.catch, law.observer is not None
    nx, nu = len(catch.state_names), len(catch.input_names)
    builder = Builder("tracking", f"Inputs of {law.name} between two rows of the table, and how far off its angles are.")
    measured = builder.input(*measurement(law))
    expected = builder.input("expected", (law.remembered,), "deviation that was expected") if seen else None
    rows = [builder.input(name, (row_width(law),), "a row of the table") for name in ("here", "next")]
    share = builder.input("f", (), "share of the way between them")[0]
    inputs = builder.output("u", (nu,), "inputs")
    off = builder.output("off", (), "squares of the angles' deviations, rad^2")
    kept = builder.output("following", (law.remembered,), "deviation that is expected at the next call") if seen else None
    reference = _reference(builder, law, rows, share)
    away = [_deviation(builder, law, measured[i], reference[i], i) for i in range(law.measured)]
    square = builder.lift(Fraction(0))
    for deviation, turns in zip(away, catch.wraps, strict=False):
        square = square + deviation * deviation if turns else square
    z = away if expected is None else _corrected(builder, law, away, expected, rows, share)
    pushed = []
    for row in range(nu):
        u = planned = _between(rows, nx + row, share)
        for i, deviation in enumerate(z[:nx]):
            u = u - _between(rows, nx + nu + row * nx + i, share) * deviation
        held = _limited(u, catch.low[row], catch.high[row])
        held = builder.let(f"{catch.input_names[row]}_held", held) if seen else held
        inputs[row] = held
        pushed.append(held - planned if seen else held)
    following = _following(builder, law, z, pushed, rows, share) if kept else []
    if expected is not None and law.observer and law.observer.learning:
        still, strain = pulled(builder, law, measured, expected, z)
        following, square = [*following, *still], square + strain
    off[0] = square
    for i, value in enumerate(following):
        assert kept is not None
        kept[i] = value
    return prune(builder.finish())


def beginning(law: TrajectoryLaw) -> Program:
    """`beginning(y_meas, here) -> following`: what the observer expects where the first measurement is, at rest."""
    builder = Builder("beginning", f"What the observer of {law.name} expects where it is first measured, at rest.")
    measured = builder.input(*measurement(law))
    here = builder.input("here", (row_width(law),), "the first row of the table")
    kept = builder.output("following", (law.remembered,), "deviation that is expected")
    for i in range(law.measured):
        kept[i] = _deviation(builder, law, measured[i], here[i], i)
    for i in range(law.measured, law.remembered):
        kept[i] = builder.lift(Fraction(0))
    return prune(builder.finish())


def measurement(law: TrajectoryLaw) -> tuple[str, tuple[int, ...], str]:
    """Name, shape and meaning of what the law reads."""
    what = ("y_meas", "measured positions, q") if law.observer else ("x_meas", "measured state, (q, v)")
    return what[0], (law.measured,), what[1]


def row_width(law: TrajectoryLaw) -> int:
    """Numbers of a row: x_r, u_r, K row by row, with an observer L, F, G row by row, and M, E where it learns parameters."""
    return sum(part[0].size for part in law.tables)


def _corrected(builder: Builder, law: TrajectoryLaw, away: list[Expr], expected: ArrayRef, rows: list[ArrayRef], f: Expr) -> list[Expr]:
    """z = expected + L w(away - expected), and theta by M behind it, within its bounds."""
    assert law.observer is not None
    nx, nq, at = law.states.shape[1], law.measured, _observer_starts(law)
    apart = []
    for i, (deviation, turns) in enumerate(zip(away, law.catch.wraps, strict=False)):
        innovation = deviation - expected[i]
        apart.append(builder.let(f"{law.catch.state_names[i]}_apart", wrapped(innovation, full_turn()) if turns else innovation))
    found = []
    last = at + nx * nq + nq * nx + nq * law.inputs.shape[1]
    for i in range(law.observer.estimated):
        z, start = expected[i], at + i * nq if i < nx else last + (i - nx) * nq
        for j, innovation in enumerate(apart):
            z = z + _between(rows, start + j, f) * innovation
        if i >= nx and law.observer.learning:
            bound = float(law.observer.learning.bounds[i - nx])
            z = minimum(maximum(z, -bound), bound)
        found.append(builder.let(f"{law.catch.state_names[i]}_off" if i < nx else f"error_{i - nx + 1}", z))
    return found


def _following(builder: Builder, law: TrajectoryLaw, z: list[Expr], pushed: list[Expr], rows: list[ArrayRef], f: Expr) -> list[Expr]:
    """z_v' = z_v + F z + G (u - u_r) + E theta, z_q' = z_q + T (z_v + z_v') / 2, theta as it is."""
    nx, nq, nu = law.states.shape[1], law.measured, law.inputs.shape[1]
    at = _observer_starts(law) + nx * nq
    rates, theta = [], z[nx:]
    for i in range(nq):
        rate: Expr = z[nq + i]
        for j in range(nx):
            rate = rate + _between(rows, at + i * nx + j, f) * z[j]
        for j in range(nu):
            rate = rate + _between(rows, at + nq * nx + i * nu + j, f) * pushed[j]
        for k, error in enumerate(theta):
            rate = rate + _between(rows, at + nq * nx + nq * nu + len(theta) * (nq + i) + k, f) * error
        rates.append(builder.let(f"{law.catch.state_names[nq + i]}_next", rate))
    half = Fraction(law.catch.sample) / 2
    return [*(z[i] + half * (z[nq + i] + rates[i]) for i in range(nq)), *rates, *theta]


def _observer_starts(law: TrajectoryLaw) -> int:
    """Where L begins in a row."""
    return sum(part[0].size for part in law.tables[:3])


def _reference(builder: Builder, law: TrajectoryLaw, rows: list[ArrayRef], f: Expr) -> list[Expr]:
    """x_r: the cubic through both rows, and its rate."""
    half, h = len(law.catch.state_names) // 2, Fraction(law.interval)
    places, rates = [], []
    for i in range(half):
        q, v = [row[i] for row in rows], [row[half + i] for row in rows]
        name = law.catch.state_names[i]
        away = builder.let(f"{name}_step", q[1] - q[0])
        speed, both = away * (6 / h), builder.let(f"{name}_speeds", v[0] + v[1])
        bend = 3 * away - h * (v[0] + both)
        places.append(builder.let(f"{name}_wanted", q[0] + f * (h * v[0] + f * (bend + f * (h * both - 2 * away)))))
        rates.append(v[0] + f * (speed - 2 * (v[0] + both) + f * (3 * both - speed)))
    return [*places, *rates]


def _between(rows: list[ArrayRef], i: int, f: Expr) -> Expr:
    return rows[0][i] + f * (rows[1][i] - rows[0][i])


def _deviation(builder: Builder, law: TrajectoryLaw, value: Expr, wanted: Expr, i: int) -> Expr:
    away = value - wanted
    name = f"{law.catch.state_names[i]}_away"
    return builder.let(name, wrapped(away, full_turn()) if law.catch.wraps[i] else away)


def _limited(u: Expr, low: float, high: float) -> Expr:
    above = maximum(u, low) if isfinite(low) else u
    return minimum(above, high) if isfinite(high) else above
