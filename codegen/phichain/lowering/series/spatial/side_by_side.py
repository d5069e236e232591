"""The loop around a recurrence as trajectories side by side in space run it: rows of the configuration, and every multiplier once."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from phichain.lowering.series.run import Arithmetic, Row, Scalar, constants_of, rubbed_places
from phichain.lowering.series.series import (
    FORCE,
    HELD,
    LATER,
    LEFT,
    LOST,
    NOW,
    RIGHT,
    ROW,
    ROW_AFTER,
    ROW_AHEAD,
    SCALE,
    SUMS,
    Series,
)
from phichain.lowering.series.spatial.rubbed import rub_lane


def expand_shared(
    series: Series, arithmetic: Arithmetic, orders: int, q: Row, v: Row, u: Sequence[Scalar] = (), rho: Fraction = Fraction(1),
    force: Sequence[Scalar] = (), lost: Sequence[Scalar] = (), **params: Row,
) -> list[Row]:  # fmt: skip
    """Coefficients (q_n, v_n) of orders 0 to `orders`, of the same arguments as `run.expand`.

    The rows are those of q alone, v_n = (n + 1) q_{n+1}, so that the last one of q is of order `orders` + 1.
    """
    assert series.order_shared is not None
    unit, nothing = [arithmetic.number(rho), arithmetic.number(rho * rho)], arithmetic.number(Fraction(0))
    given = {"q": q, "v": v, "u": u, SCALE: unit, LOST: list(lost) or [nothing] * (len(q) + len(v)), FORCE: list(force[:1]), **params}
    made = arithmetic.run(series.factor, given)
    links, carts = series.lanes // 3, len(q) - series.lanes
    rows, rights = [list(q), [*v[:carts], *made[LEFT]]], [[nothing] * (links + (series.rights - 1) * series.lanes)]
    rubs = rubbed_places(series, arithmetic, list(made[LEFT]), orders)
    for n in range(orders):
        left = [row[carts:] for row in rows[1:]]
        sums = [
            arithmetic.total((left[j][i], rights[n - j][i // 3 if row == 0 else links + (row - 1) * series.lanes + i]) for j in range(n + 1))
            for row in range(series.rights)
            for i in range(series.lanes)
        ]
        sums += [arithmetic.total((left[j][i], left[n - j][i]) for j in range(n + 1) for i in range(3 * k, 3 * k + 3)) for k in range(links)]
        for i, place in enumerate(rubs):
            sums += place.sums([row[rub_lane(series, i) :] for row in left], n)
        is_late = bool(n) and series.is_forced
        weight = force[n] if is_late else arithmetic.number(Fraction(n == 0))
        held = made[LATER if is_late else HELD]
        now = {NOW: [*constants_of(arithmetic, n), weight], FORCE: [weight]}
        found = arithmetic.run(series.order_shared, {HELD: list(held), SUMS: sums, ROW: rows[n], ROW_AFTER: rows[n + 1], **now, **params})
        rows.append(list(found[ROW_AHEAD]))
        rights.append(list(found[RIGHT]))
    return [
        [*rows[n][: len(q)], *(arithmetic.total([(arithmetic.number(Fraction(n + 1)), x)]) for x in rows[n + 1][: len(q)])]
        for n in range(orders + 1)
    ]
