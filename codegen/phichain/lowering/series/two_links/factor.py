"""The factorisation of a planar step of two links, multiplied out: what an order gives, by what it knows.

An order knows of each link the moment y, C'' and e, which is S'' less the turning z. What it gives is linear in those six, with the
numbers of `lowering.series.planar` (o = m r^2, or what a rigid link has for it; s, c of the outer joint)

    S''_0 = (y_0 + o_0 e_0) / D - l s m_1 r_1 C''_1 / D - l c (y_1 + o_1 e_1) / (D r_1)
    z_0 = S''_0 - e_0 - U_x l C''_0 / D,     a_1 = Q^T (l C''_0, 0) + l S''_0 (s, c),     z_1 = y_1 / o_1 - a_1y / r_1
    f_0 = -l (c m_1 r_1 C''_1 - s (y_1 + o_1 e_1) / r_1 + m_1 c a_1x),     f_1 = -m_1 r_1 a_1x

a_1 being the outer joint's acceleration in its link's frame and f the moments along the links: rows of six numbers each. C''_0 adds what
stands beside it, and what is constant in time acts at order 0 alone. No number of a row is a difference that cancels: 1 - l^2 m_1 s^2 / D is o_0 / D.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final

from phichain.ir.builder import ArrayRef, Expr, Index
from phichain.lowering.series.planar_factor import Factor, directions

ROWS: Final = ("turning_0", "joint_x", "joint_y", "axial_0")
"""Each by y, then C'', then e of both links; what is constant in time has a number in each."""


def runs() -> Iterable[tuple[str, int]]:
    """What a step holds beside inputs and joints."""
    return [*((name, 6) for name in ROWS), ("still", 4), ("tip", 2)]


class TwoFactor(Factor):
    """The elimination of the outer link, then of the inner one, then the rows."""

    def keep(self, name: str, k: Index, value: Expr) -> None:
        """Note a number of link k, and store it where the scene has a place for it."""
        if isinstance(k, int):
            self._kept[name, k] = value
        super().keep(name, k, value)

    def write(self, q: ArrayRef, lost: ArrayRef, u: ArrayRef | None) -> None:
        """All numbers of `held`."""
        self._kept: dict[tuple[str, int], Expr] = {}
        self.sine, self.cosine = directions(self.builder, self.scene, q, lost)
        self.base(self.link(self.tip(1), 0))
        self.rows()
        self.inputs(u)
        self.hold_moments()
        if "rest" in self.layout:
            self.rests(q, lost)

    def rows(self) -> None:
        """What an order gives by what it knows."""
        zero = self.builder.lift(0)
        length = self.parameters.length[0]

        def of(name: str, k: int) -> Expr:
            return self._kept.get((name, k), zero)

        def let(name: str, value: Expr) -> Expr:
            return self.builder.let(name, value)

        s, c, inverse, own = of("sine", 1), of("cosine", 1), of("inverse", 0), self.links.own
        gain, pull, outer = of("gain_y", 1), of("pull_x", 1), of("axial", 1)
        # S''_0 by y_0, y_1, C''_1, e_0, e_1.
        share = let("share", own[0] * inverse)
        across = -(of("arm_y", 0) * gain)
        lifted = (inverse, across, zero, -(of("arm_x", 0) * outer), share, across * own[1])
        lean, rise = let("lean", length * s), let("rise_by", length * c)
        joint_x = [lean * entry for entry in lifted]
        joint_y = [rise * entry for entry in lifted]
        joint_x[2], joint_y[2] = of("q_xx", 0) * length, of("q_xy", 0) * length
        turning = [*lifted[:2], -(of("gain_x", 0) * length), lifted[3], -of("lag", 0), lifted[5]]
        base_x, base_y = of("base", 0), of("base", 1)
        still_x = let("still_x", of("q_xx", 0) * base_x + of("q_yx", 0) * base_y)
        still_y = of("q_xy", 0) * base_x + of("q_yy", 0) * base_y
        arm = let("pull_arm", length * pull)
        # The tip's own force there: C''_1 through the link, less what the joint's acceleration takes back; y_1 and e_1 across it.
        aside = let("aside", lean * gain)
        axial = [-(arm * entry) for entry in joint_x]
        axial[1], axial[5] = axial[1] + aside, axial[5] + aside * own[1]
        axial[3] = -(length * (c * outer) * share)
        rows = {"turning_0": turning, "joint_x": joint_x, "joint_y": joint_y, "axial_0": axial}
        for name, row in rows.items():
            for i, entry in enumerate(row):
                self.layout.of(self.held, name)[i] = entry
        turned = -(of("gain_x", 0) * base_x + of("gain_y", 0) * base_y)
        for i, entry in enumerate((turned, still_x, still_y, -(self.links.moment[0] * base_x + arm * still_x))):
            self.layout.of(self.held, "still")[i] = entry
        self.layout.of(self.held, "tip")[0] = of("inverse", 1)
        self.layout.of(self.held, "tip")[1] = gain
