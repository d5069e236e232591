"""What the Taylor flow of a chain is made of: a factorisation once per step, and one back substitution per order."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from phichain.ir.nodes import Program

#: Numbers of a left row, and sums of an order, for each place of a spatial chain where dry friction acts.
RUB_LANES: Final = 5
RUB_SUMS: Final = 6

#: Highest order of the Taylor series. Near round-off higher ones only make longer steps, over which larger terms cancel:
#: 28 lost half a digit against 22 on a pendulum that whirls, in the same time.
HIGHEST: Final = {"double": 22, "float": 14}

#: Arrays of the Programs.
HELD: Final = "held"
LEFT: Final = "left"
RIGHT: Final = "right"
SUMS: Final = "sums"
NEWEST: Final = "newest"
SCALE: Final = "scale"
LOST: Final = "lost"
NOW: Final = "now"
COEFFICIENT: Final = "coefficient"
NEXT: Final = "next"
LEAD: Final = "lead"
ROW: Final = "row"
ROWS: Final = "rows"
ROW_AFTER: Final = "row_after"
ROW_AHEAD: Final = "row_ahead"
LATER: Final = "later"
FORCE: Final = "force"


@dataclass(frozen=True)
class Series:
    """The Taylor recurrences of a chain in scaled time t = t_0 + rho u.

    The equations of motion M(q) a = rhs hold order by order with the same matrix M(q_0). `factor` factors it once per
    step; `order` then solves for the coefficients of order n + 1 with constant numbers, given the sums

        sums_n[r, i] = sum_{j=0..n} left_j[i] right_{n-j}[r, i],   squares_n[i] = sum_{j=0..n} left_j[i] left_{n-j}[i]

    Where dry friction acts (`dry` places), left rows go on behind their lanes with y, s and d of every place, and sums with

        sums_n = sum_{j=1..n} s_{n+1-j} d_j,   sum_{j=1..n} y_j y_{n+1-j}

    Attributes:
        factor: state (q, v), [u], scale [rho, rho^2], [what rounding took from the state, `lost`] -> held, rows 0 of left and right.
        order: held, sums, [row n of left, `newest`], coefficient of order n, now [n + 1, 1/(n + 1), 1/((n + 1)(n + 2)), n = 0] -> rows n + 1, next.
        columns: held, rows 0, dq, dv -> lead, variations of rows 0; None where no derivatives are wanted.
        lanes: entries of a left row that are multiplied with right ones.
        rights: right rows, each as long as a left one.
        squares: so many first lanes of left are also convolved with themselves.
        held: numbers that `factor` keeps.
        is_forced: whether a forcing drives the chain: `factor` is then given its value as well, `force`, and makes a second
            `held`, `later`; `order` is given `force`, 1 with `held` at n = 0 and the forcing's coefficient of order n with `later`.
        tangent: the order of derivatives along the state where it is another one than `order`.
        factor_along: how `held` moves with parameters, `d_NAME`; None where no derivatives by them are wanted.
        order_along: the order of derivatives by parameters.
        dry: places of a planar chain where dry friction acts, with three more entries of a left row each.
        rubs: places of a spatial one, with five (`series.spatial.rubs`).
        order_shared: the order of trajectories side by side in space, which keep what every number is once (`series.spatial.ordering`):
            held, sums with the squares of a link as one, rows n and n + 1 of the configuration, `row` and `row_after`, now -> `row_ahead`, its
            row n + 2, and right row n + 1 with every multiplier once. None in the plane.
        by_links: whether left rows are cosines, then sines of links' angles, the first two right rows their rates, and the other two
            begin with zero, their sums being wanted together only: then derivatives of sums are known by those of the angles.
        outright: coefficients of all orders at once, straight-line: held, right row 0, slope of order 1 -> `rows`, orders 0 to the highest of
            what the state moves by; None where orders come one by one.
    """

    factor: Program
    order: Program
    columns: Program | None
    lanes: int
    rights: int
    squares: int
    held: int
    is_forced: bool = False
    tangent: Program | None = None
    factor_along: Program | None = None
    order_along: Program | None = None
    dry: int = 0
    rubs: int = 0
    by_links: bool = False
    order_shared: Program | None = None
    outright: Program | None = None

    @property
    def order_of_columns(self) -> Program:
        """The order of derivatives along the state."""
        return self.order if self.tangent is None else self.tangent

    @property
    def width(self) -> int:
        """Entries of a left row."""
        return self.lanes + 3 * self.dry + RUB_LANES * self.rubs

    @property
    def sums(self) -> int:
        """Sums of one order."""
        return self.lanes * self.rights + self.squares + 2 * self.dry + RUB_SUMS * self.rubs

    @property
    def shared_right(self) -> int:
        """Entries of a right row where trajectories share rows: every multiplier once."""
        return self.lanes // 3 + self.lanes * (self.rights - 1)

    @property
    def shared_sums(self) -> int:
        """Sums of one order there: a link's squares are one."""
        return self.lanes * self.rights + self.lanes // 3 + RUB_SUMS * self.rubs
