"""The articulated sweep of `articulated` on a fixed base with its two ends written out, for straight-line code on targets (docs/theory.md, section 5).

Nothing lies beyond the last link, whose force and k' are multiples of one pair: turned is (-w^2, tau), with lambda and all units in one
factor,

    b' = lambda (-w^2, tau),   k' = lambda^2 (0, tau),

and what carries the first link is given, so that neither its elimination nor 1 / D is kept:

    a'_y = (tau - b_y - A_xy (a_x - w^2) - (lambda - 1) a_y) / D.

It is the same sums, by one division for a reciprocal and four products, and by one product for two.
"""

from __future__ import annotations

from dataclasses import replace

from phichain.ir.builder import ArrayRef, Builder, Expr, Index
from phichain.lowering.chain.parameters import Parameters
from phichain.lowering.chain.room import saves_memory, saves_text
from phichain.lowering.planar.articulated import Outer, Sweep
from phichain.lowering.planar.joints import PlanarState, couples, from_absolute
from phichain.scene import Scene

#: Up to so many links the force of the last one is turned before it is multiplied; of more its parts are wanted by so many sums that
#: multiplying first takes fewer operations.
_FEW_LINKS = 3


def suits(scene: Scene) -> bool:
    """Whether room is dear, and not so dear that one loop serves all links; points on links, the first of them on a wall."""
    return saves_memory(scene) and not saves_text(scene) and not scene.has_cart and scene.inertia is None


def accelerations(
    builder: Builder, scene: Scene, parameters: Parameters, state: PlanarState, u: ArrayRef | None, a: ArrayRef
) -> None:
    """Write the accelerations theta'' into `a`."""
    sweep = _Ends(builder, scene, parameters, state, couples(builder, scene, parameters, state, u))
    alpha, inverse = builder.array("acceleration", scene.links), 1 / parameters.length[0]
    end = sweep.first_link(sweep.inwards(), alpha, (inverse * -parameters.fall[1], inverse * -parameters.fall[0]))
    with builder.loop("k", 1, scene.links) as loop:
        sweep.outwards(alpha, loop, end, loop.index)
    from_absolute(builder, scene, alpha, a)


class _Ends(Sweep):
    """The sweep with both ends written out."""

    def beyond(self, k: int) -> Outer:
        """Link k and all beyond it, seen from the link before."""
        if k == self.scene.links or self.scene.links > _FEW_LINKS:
            return super().beyond(k)
        outer = self._last_link()
        for link in range(self.scene.links - 2, k - 1, -1):
            outer = self.eliminate(outer, link)
        return outer

    def _last_link(self) -> Outer:
        """The last link, seen from the link before: its force is turned before it is multiplied."""
        k, zero, units = self.scene.links - 1, self.builder.lift(0), self.units
        nothing = super().beyond(self.scene.links)
        pivot = self.pivot(nothing, k)
        still = replace(self.with_link(nothing, pivot, k), force_x=zero, force_y=zero, minor_y=zero)
        let, sine, cosine = self.builder.let, self.sine[k], self.cosine[k]
        force, minor = self.factors.force[k] * units.leverage[k], self.factors.minor_force[k] * units.leverage[k]
        across, along = sine * pivot.drive, cosine * pivot.drive
        return replace(
            self._turned(still, k),
            force_x=let("outer_force_x", -(force * (cosine * pivot.rate_squared + across))),
            force_y=let("outer_force_y", force * (along - sine * pivot.rate_squared)),
            minor_x=let("outer_minor_x", -(minor * across)),
            minor_y=let("outer_minor_y", minor * along),
        )

    def determinant(self, outer: Outer, inverse: Expr, k: Index) -> Expr:
        """(lambda^2 A_yy + E) / D over lambda: a multiple of what A_yy becomes where E is zero, beyond the last but one."""
        if outer.determinant.is_zero:
            return self.units.leverage[k] * (outer.yy * inverse)
        return super().determinant(outer, inverse, k)

    def first_link(self, outer: Outer, alpha: ArrayRef, base: tuple[Expr, Expr]) -> tuple[Expr, Expr]:
        """Write the first link's acceleration, its joint's given less gravity and over its length; that of its outer end."""
        let, sine, cosine = self.builder.let, self.sine[0], self.cosine[0]
        rate_squared = let("rate_squared_0", self.state.rate[0] * self.state.rate[0])
        drive = self.builder.lift(0)
        if self.couple is not None:
            drive = let("drive_0", self.couple[0] * self.units.inverse_torque[0])
        joint_x = let("joint_x_0", cosine * base[0] + sine * base[1])
        joint_y = let("joint_y_0", cosine * base[1] - sine * base[0])
        tip_x = joint_x - rate_squared
        push = drive - outer.force_y - outer.xy * tip_x - self.units.overhang[0] * joint_y
        tip_y = let("tip_y_0", push / (1 + outer.yy))
        alpha[0] = tip_y - joint_y
        return tip_x, tip_y
