"""The loop around the Programs of a recurrence, in any arithmetic: doubles, many digits, or the integers modulo a prime.

What the C of the flows does with a `Series`: sums of products of rows, one back substitution an order.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
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
    RUB_LANES,
    SCALE,
    SUMS,
    Series,
)
from phichain.lowering.series.spatial.rubbed import Rubbed, rub_lane

Scalar = Any
Row = list[Scalar]


@dataclass(frozen=True)
class Arithmetic:
    """What the loop needs of its numbers.

    Attributes:
        run: runs a Program on flat arguments by name, the runtime parameters among them.
        number: makes a scalar of an exact number.
        total: the sum of products of two scalars each.
        inverse: 1 / x.
    """

    run: Callable[[Program, Mapping[str, Sequence[Scalar]]], Mapping[str, Sequence[Scalar]]]
    number: Callable[[Fraction], Scalar]
    total: Callable[[Iterable[tuple[Scalar, Scalar]]], Scalar]
    inverse: Callable[[Scalar], Scalar] = lambda x: 1 / x


@dataclass(frozen=True)
class Expanded:
    """Coefficients of a step in scaled time.

    Attributes:
        state: (q_n, v_n) by order.
        left: rows of left.
        right: rows of right, one behind the other.
        held: constants of the step.
        later: those that a forcing leaves to the orders behind the first; the same without one.
        sums: the sums of products by order.
        given: what the factorisation was given, by name.
        force: the forcing's coefficients.
    """

    state: list[Row]
    left: list[Row]
    right: list[Row]
    held: Row
    later: Row
    sums: list[Row] = field(default_factory=list)
    given: Mapping[str, Sequence[Scalar]] = field(default_factory=dict)
    force: Sequence[Scalar] = ()
    rubs: Sequence[Rubbed] = ()


def expand(
    series: Series,
    arithmetic: Arithmetic,
    orders: int,
    q: Row,
    v: Row,
    u: Sequence[Scalar] = (),
    rho: Fraction = Fraction(1),
    force: Sequence[Scalar] = (),
    lost: Sequence[Scalar] = (),
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
        lost: what rounding took from q and v; nothing where it is not given.
        params: values of the runtime parameters.
    """
    unit = [arithmetic.number(rho), arithmetic.number(rho * rho)]
    rest = list(lost) or [arithmetic.number(Fraction(0))] * (len(q) + len(v))
    given = {"q": q, "v": v, "u": u, SCALE: unit, LOST: rest, FORCE: list(force[:1]), **params}
    made = arithmetic.run(series.factor, given)
    held = list(made[HELD])
    later = list(made[LATER]) if series.is_forced else held
    left = list(made[LEFT])
    found = Expanded([[*q, *v]], [left], [list(made[RIGHT])], held, later, [], given, force, rubbed_places(series, arithmetic, left, orders))
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
        for i, place in enumerate(found.rubs):
            sums += place.sums([row[rub_lane(series, i) :] for row in found.left], n)
        found.sums.append(sums)
        weight = force[n] if n and series.is_forced else arithmetic.number(Fraction(n == 0))
        _next(series.order, arithmetic, found, sums, n, weight, params)
    return found


def rubbed_places(series: Series, arithmetic: Arithmetic, left: Row, orders: int) -> list[Rubbed]:
    """The places of a spatial chain where dry friction acts, from row 0 of left."""
    rows = [left[rub_lane(series, i) :] for i in range(series.rubs)]
    return [Rubbed(arithmetic.total, arithmetic.number, arithmetic.inverse, row[:RUB_LANES], orders) for row in rows]


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
    lead, found = _column(series, arithmetic, base, dq, dv, params)
    for n in range(len(base.state) - 1):
        sums = _moved_sums(series, arithmetic, base, found, lead, n, is_linear=True)
        _next(series.order_of_columns, arithmetic, found, sums, n, arithmetic.number(Fraction(0)), params)
    return found


def expand_along(
    series: Series,
    arithmetic: Arithmetic,
    base: Expanded,
    dq: Row,
    dv: Row,
    moved: Mapping[str, Row],
    d_force: Sequence[Scalar] = (),
    **params: Row,
) -> Expanded:
    """Derivatives of the coefficients along a variation of the state and of the parameters: as many orders as `base` has, but for its last.

    Args:
        series: the recurrences, with derivatives by parameters.
        arithmetic: the numbers.
        base: coefficients of the motion itself.
        dq: variation of the configuration.
        dv: and of its rates in scaled time.
        moved: variation of the parameters that are varied, by name.
        d_force: and of the forcing's coefficients, where there is one.
        params: values of the runtime parameters.
    """
    assert series.factor_along is not None and series.order_along is not None
    nothing = arithmetic.number(Fraction(0))
    slopes = {f"d_{name}": list(values) for name, values in moved.items()}
    step = arithmetic.run(series.factor_along, {**base.given, **slopes, f"d_{FORCE}": list(d_force[:1]), **params})
    lead, found = _column(series, arithmetic, base, dq, dv, params)
    for n in range(len(base.state) - 1):
        is_late = bool(n) and series.is_forced
        name, held = (LATER, base.later) if is_late else (HELD, base.held)
        weight = base.force[n] if is_late else arithmetic.number(Fraction(n == 0))
        given = {
            HELD: held, SUMS: base.sums[n], NEWEST: base.left[n], COEFFICIENT: base.state[n], NOW: [*constants_of(arithmetic, n), weight],
            FORCE: [weight], f"d_{HELD}": step[f"d_{name}"], f"d_{SUMS}": _moved_sums(series, arithmetic, base, found, lead, n),
            f"d_{NEWEST}": found.left[n], f"d_{COEFFICIENT}": found.state[n], f"d_{FORCE}": [d_force[n] if is_late else nothing],
        }  # fmt: skip
        made = arithmetic.run(series.order_along, {**given, **slopes, **params})
        for rows, row in ((found.left, LEFT), (found.right, RIGHT), (found.state, NEXT)):
            rows.append(list(made[f"d_{row}"]))
    return found


def _column(
    series: Series, arithmetic: Arithmetic, base: Expanded, dq: Row, dv: Row, params: Mapping[str, Row]
) -> tuple[Row, Expanded]:
    """Where a column starts: what leads, and rows 0."""
    assert series.columns is not None
    made = arithmetic.run(
        series.columns,
        {HELD: base.held, LEFT: base.left[0], RIGHT: base.right[0], "dq": dq, "dv": dv, **params},
    )
    rows = [list(made[f"d_{LEFT}"])], [list(made[f"d_{RIGHT}"])]
    return list(made[LEAD]), Expanded([[*dq, *dv]], *rows, base.held, base.held)


def _moved_sums(
    series: Series, arithmetic: Arithmetic, base: Expanded, found: Expanded, lead: Row, n: int, is_linear: bool = False
) -> Row:
    """Derivatives of the sums of order n; for an order that is linear in them with what multiplies others as it is."""
    lanes, rows = series.lanes, [lead, *found.left]
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
    for i, place in enumerate(base.rubs):
        own, moved = ([row[rub_lane(series, i) :] for row in rows] for rows in (base.left, found.left))
        sums += [*place.moved_sums(own, moved, n), place.slopes[1] if is_linear else arithmetic.number(Fraction(0))]
    return sums


def constants_of(arithmetic: Arithmetic, n: int) -> Row:
    return [arithmetic.number(x) for x in (Fraction(n + 1), Fraction(1, n + 1), Fraction(1, (n + 1) * (n + 2)))]


def _next(
    order: Program,
    arithmetic: Arithmetic,
    found: Expanded,
    sums: Row,
    n: int,
    weight: Scalar,
    params: Mapping[str, Row],
) -> None:
    given = {
        HELD: found.later if n else found.held,
        SUMS: sums,
        NEWEST: found.left[n],
        COEFFICIENT: found.state[n],
        NOW: [*constants_of(arithmetic, n), weight],
        FORCE: [weight],
    }
    made = arithmetic.run(order, {**given, **params})
    found.left.append(list(made[LEFT]))
    found.right.append(list(made[RIGHT]))
    found.state.append(list(made[NEXT]))
