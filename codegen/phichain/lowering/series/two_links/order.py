"""The back substitution of one order of a planar step of two links: rows of six numbers instead of sweeps."""

from __future__ import annotations

from typing import ClassVar

from phichain.ir.builder import ArrayRef, Expr
from phichain.lowering.series.planar_order import Order


class TwoOrder(Order):
    """Everything at once: fewer operations wait for each other than in two sweeps. What comes last of the order before, the moments along
    the links in y, stands last in each sum."""

    WORK: ClassVar[tuple[str, ...]] = ("bend", "torque", "turn", "swing", "rise")

    def write(self, sums: ArrayRef, coefficient: ArrayRef, left: ArrayRef, right: ArrayRef, following: ArrayRef) -> None:
        """All cells of the results."""
        builder, work, now, tip = self.builder, self.work, self.now, self.of("tip")
        self.moments(sums, coefficient)
        turning = builder.let("turning", self._row("turning_0", 0))
        x, y = builder.let("joint_x", self._row("joint_x", 1)), builder.let("joint_y", self._row("joint_y", 2))
        axial = self._row("axial_0", 3)
        work["swing"][0], work["swing"][1] = turning, tip[0] * work["torque"][1] - tip[1] * y
        for k in range(2):
            work["turn"][k] = rate = builder.let("rate", now[1] * work["swing"][k])
            left[k], left[k + 2] = now[2] * work["bend"][k], now[2] * (work["swing"][k] + work["rise"][k])
            right[k], right[k + 2] = rate, rate
        right[4], right[5] = work["torque"][0] - self.own[0] * turning, self.moment[1] * y
        right[6], right[7] = axial, -(self.moment[1] * x)
        self.state(coefficient, following)
        self.rub(sums, left)

    def moments(self, sums: ArrayRef, coefficient: ArrayRef) -> None:
        """What is known of each link."""
        now, work, couple = self.now, self.work, self.couple(coefficient)
        for k in range(2):
            work["bend"][k] = -(now[0] * sums[k + 2])
            work["rise"][k] = now[0] * sums[k]
            borne = -sums[k + 4] if couple is None else couple[k] - sums[k + 4]
            work["torque"][k] = self.builder.let("torque", borne - sums[k + 6])

    def _row(self, name: str, still: int) -> Expr:
        row, work = self.of(name), self.work
        total = self.now[3] * self.of("still")[still]
        for part, first in (("rise", 4), ("bend", 2), ("torque", 0)):
            for k in range(2):
                total = total + row[first + k] * work[part][k]
        return total
