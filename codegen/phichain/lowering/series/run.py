"""The loop around the Programs of a recurrence, in any arithmetic: doubles, many digits, or the integers modulo a prime.

What the C of the flows does with a `Series`: sums of products of rows, one back substitution an order.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from phichain.ir.nodes import Program
from phichain.lowering.series.series import (
    COEFFICIENT,
    FORCE,
    HELD,
    LATER,
    LEAD,
    LEFT,
    LOST,
    NEWEST,
    NEXT,
    NOW,
    RIGHT,
    SCALE,
    SUMS,
    Series,
)

Scalar = Any
Row = list[Scalar]


@dataclass(frozen=True)
class Arithmetic:
    """What the loop needs of its numbers.

    Attributes:
        run: runs a Program on flat arguments by name, the runtime parameters among them.
        number: makes a scalar of an exact number.
        total: the sum of products of two scalars each.
    """

    run: Callable[[Program, Mapping[str, Sequence[Scalar]]], Mapping[str, Sequence[Scalar]]]
    number: Callable[[Fraction], Scalar]
    total: Callable[[Iterable[tuple[Scalar, Scalar]]], Scalar]


@dataclass(frozen=True)
class Expanded:
    """Coefficients of a step in scaled time.

    Attributes:
        state: (q_n, v_n) by order.
        left: rows of left.
        right: rows of right, one behind the other.
        held: constants of the step.
        later: those that a forcing leaves to the orders behind the first; the same without one.
    """

    state: list[Row]
    left: list[Row]
    right: list[Row]
    held: Row
    later: Row


def expand(
    series: Series,
    arithmetic: Arithmetic,
    orders: int,
    q: Row,
    v: Row,
    u: Sequence[Scalar] = (),
    rho: Fraction = Fraction(1),
    force: Sequence[Scalar] = (),
    **params: Row,
) -> Expanded:
    """Coefficients of orders 0 to `orders`.

    Args:
        series: the recurrences.
        arithmetic: the numbers.
        orders: the last order.
        q: configuration.
        v: its rates in scaled time.
        u: inputs.
        rho: the unit of time.
        force: the forcing's coefficients in scaled time, where there is one.
        params: values of the runtime parameters.
    """
    unit = [arithmetic.number(rho), arithmetic.number(rho * rho)]
    nothing = [arithmetic.number(Fraction(0))] * (len(q) + len(v))
    given = {"q": q, "v": v, "u": u, SCALE: unit, LOST: nothing, FORCE: list(force[:1]), **params}
    made = arithmetic.run(series.factor, given)
    held = list(made[HELD])
    later = list(made[LATER]) if series.is_forced else held
    found = Expanded([[*q, *v]], [list(made[LEFT])], [list(made[RIGHT])], held, later)
    for n in range(orders):
        sums = [
            arithmetic.total(
                (found.left[j][i], found.right[n - j][row * series.lanes + i]) for j in range(n + 1)
            )
            for row in range(series.rights)
            for i in range(series.lanes)
        ]
        sums += [
            arithmetic.total((found.left[j][i], found.left[n - j][i]) for j in range(n + 1))
            for i in range(series.squares)
        ]
        weight = force[n] if n and series.is_forced else arithmetic.number(Fraction(n == 0))
        _next(series.order, arithmetic, found, sums, n, weight, params)
    return found


def expand_column(
    series: Series, arithmetic: Arithmetic, base: Expanded, dq: Row, dv: Row, **params: Row
) -> Expanded:
    """Derivatives of the coefficients along a variation of the state: as many orders as `base` has, but for its last.

    Args:
        series: the recurrences, with columns.
        arithmetic: the numbers.
        base: coefficients of the motion itself.
        dq: variation of the configuration.
        dv: and of its rates in scaled time.
        params: values of the runtime parameters.
    """
    assert series.columns is not None
    made = arithmetic.run(
        series.columns,
        {HELD: base.held, LEFT: base.left[0], RIGHT: base.right[0], "dq": dq, "dv": dv, **params},
    )
    lead, lanes = list(made[LEAD]), series.lanes
    found = Expanded([[*dq, *dv]], [list(made[f"d_{LEFT}"])], [list(made[f"d_{RIGHT}"])], base.held, base.held)
    for n in range(len(base.state) - 1):
        rows = [lead, *found.left]
        sums = [
            arithmetic.total(
                [(rows[j + 1][i], base.right[n - j][row * lanes + i]) for j in range(-1, n + 1)]
                + [(base.left[j][i], found.right[n - j][row * lanes + i]) for j in range(n + 1)]
            )
            for row in range(series.rights)
            for i in range(lanes)
        ]
        sums += [
            arithmetic.total([(rows[j + 1][i], base.left[n - j][i]) for j in range(-1, n + 1)] * 2)
            for i in range(series.squares)
        ]
        _next(series.order_of_columns, arithmetic, found, sums, n, arithmetic.number(Fraction(0)), params)
    return found


def _next(
    order: Program,
    arithmetic: Arithmetic,
    found: Expanded,
    sums: Row,
    n: int,
    weight: Scalar,
    params: Mapping[str, Row],
) -> None:
    now = [Fraction(n + 1), Fraction(1, n + 1), Fraction(1, (n + 1) * (n + 2))]
    given = {
        HELD: found.later if n else found.held,
        SUMS: sums,
        NEWEST: found.left[n],
        COEFFICIENT: found.state[n],
        NOW: [*(arithmetic.number(x) for x in now), weight],
        FORCE: [weight],
    }
    made = arithmetic.run(order, {**given, **params})
    found.left.append(list(made[LEFT]))
    found.right.append(list(made[RIGHT]))
    found.state.append(list(made[NEXT]))
