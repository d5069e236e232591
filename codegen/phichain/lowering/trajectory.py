"""A law along a trajectory -> Programs: what happens between two rows of its table."""

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


def tracking(law: TrajectoryLaw) -> Program:
    """`tracking(x_meas, here, next, f) -> u, off`: the law a share f of the way from one row of its table to the next.

    A row is x_r, u_r, K row by row. With d = q_1 - q_0 and h from one row to the next,

        q_r = q_0 + f (h v_0 + f (3 d - h (2 v_0 + v_1) + f (h (v_0 + v_1) - 2 d)))
        v_r = v_0 + f (6 d / h - 4 v_0 - 2 v_1 + f (3 (v_0 + v_1) - 6 d / h))
        u   = clip(u_0 + f (u_1 - u_0) - (K_0 + f (K_1 - K_0)) w(x_meas - x_r), low, high),

    and off the sum of the squares of the angles' deviations. What is not a number spreads into u and off.
    """
    catch = law.catch
    nx, nu = len(catch.state_names), len(catch.input_names)
    builder = Builder("tracking", f"Inputs of {law.name} between two rows of the table, and how far off its angles are.")
    measured = builder.input("x_meas", (nx,), "measured state, (q, v)")
    rows = [builder.input(name, (nx + nu + nu * nx,), "a row of the table") for name in ("here", "next")]
    share = builder.input("f", (), "share of the way between them")[0]
    inputs = builder.output("u", (nu,), "inputs")
    off = builder.output("off", (), "squares of the angles' deviations, rad^2")
    reference = _reference(builder, law, rows, share)
    away = [_deviation(builder, law, measured[i], reference[i], i) for i in range(nx)]
    square = builder.lift(Fraction(0))
    for deviation, turns in zip(away, catch.wraps, strict=True):
        square = square + deviation * deviation if turns else square
    for row in range(nu):
        u = _between(rows, nx + row, share)
        for i, deviation in enumerate(away):
            u = u - _between(rows, nx + nu + row * nx + i, share) * deviation
        inputs[row] = _limited(u, catch.low[row], catch.high[row])
    off[0] = square
    return prune(builder.finish())


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
