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
    HELD,
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
    """

    state: list[Row]
    left: list[Row]
    right: list[Row]
    held: Row


def expand(
    series: Series,
    arithmetic: Arithmetic,
    orders: int,
    q: Row,
    v: Row,
    u: Sequence[Scalar] = (),
    rho: Fraction = Fraction(1),
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
        params: values of the runtime parameters.
    """
    unit = [arithmetic.number(rho), arithmetic.number(rho * rho)]
    nothing = [arithmetic.number(Fraction(0))] * (len(q) + len(v))
    made = arithmetic.run(series.factor, {"q": q, "v": v, "u": u, SCALE: unit, LOST: nothing, **params})
    found = Expanded([[*q, *v]], [list(made[LEFT])], [list(made[RIGHT])], list(made[HELD]))
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
        sums += [
            arithmetic.total((found.left[n + 1 - j][a], found.left[j][b]) for j in range(1, n + 1))
            for a, b in _dry_pairs(series)
        ]
        _next(series, arithmetic, found, sums, n, n == 0, params)
    return found


def _dry_pairs(series: Series) -> list[tuple[int, int]]:
    """Lanes of left rows that dry friction multiplies: steepness and change, and saturation with itself."""
    places = range(series.lanes, series.lanes + series.dry)
    return [(i + series.dry, i + 2 * series.dry) for i in places] + [(i, i) for i in places]


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
    found = Expanded([[*dq, *dv]], [list(made[f"d_{LEFT}"])], [list(made[f"d_{RIGHT}"])], base.held)
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
        sums += [
            arithmetic.total(
                [(found.left[j][a], base.left[n + 1 - j][b]) for j in range(n + 1)]
                + [(base.left[n + 1 - j][a], found.left[j][b]) for j in range(n + 1)]
            )
            for a, b in _dry_pairs(series)
        ]
        _next(series, arithmetic, found, sums, n, False, params)
    return found


def _next(
    series: Series,
    arithmetic: Arithmetic,
    found: Expanded,
    sums: Row,
    n: int,
    is_first: bool,
    params: Mapping[str, Row],
) -> None:
    now = [Fraction(n + 1), Fraction(1, n + 1), Fraction(1, (n + 1) * (n + 2)), Fraction(is_first)]
    given = {
        HELD: found.held,
        SUMS: sums,
        NEWEST: found.left[n],
        COEFFICIENT: found.state[n],
        NOW: [arithmetic.number(x) for x in now],
    }
    made = arithmetic.run(series.order, {**given, **params})
    found.left.append(list(made[LEFT]))
    found.right.append(list(made[RIGHT]))
    found.state.append(list(made[NEXT]))
