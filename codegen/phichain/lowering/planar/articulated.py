"""Planar forward dynamics with masses anywhere on their links: an articulated sweep (docs/theory.md, section 5).

Frames have x along the link and y along its tangent and are turned from joint to joint by the joint's angle. The chain
beyond a joint asks for the force A a + b there, a the joint's acceleration minus gravity. Everything about a link is in its
own units, m (r / l)^2 of mass and l of length, with lambda = l / r, E = det A, k = adj(A) b, w the absolute rate and tau the
couple on the link. In the frame of the link, before and after it is eliminated,

    D = 1 + A_yy,   A'_xx = lambda^2 + (A_xx + E) / D,   A'_xy = -(lambda - 1) A_xy / D,   A'_yy = (lambda - 1)^2 A_yy / D
    E' = (lambda - 1)^2 (lambda^2 A_yy + E) / D
    free = (tau - b_y + w^2 A_xy) / D,   b'_y = tau + (lambda - 1) free
    b'_x = (b_x + k_x + tau A_xy) / D - w^2 (lambda + (A_xx + E) / D)
    k'_x = (lambda - 1) ((lambda - 1) (k_x - w^2 (E + lambda A_yy)) + lambda tau A_xy) / D
    k'_y = lambda^2 b'_y + (tau (lambda A_xx + E) - (lambda - 1) (k_y + lambda w^2 A_xy)) / D

and outwards the link's tip is accelerated by free - (A_xy a_x + (lambda - 1) a_y) / D along its tangent, a_y + phi''. On a cart
(m_c + A_yy) x'' = u - b_y + g A_xy.

E and k are carried because A and b alone cancel: b_x + k_x stands for b_x D - A_xy b_y, whose terms are as large as the
heaviest mass beyond while their difference is as small as the lightest. Carried are E / lambda and k / lambda, which leaves
no factor in the usual case r = l / 2; of rigid links E and k themselves, since their lambda may be zero. There phi'' is no
difference of accelerations either: phi'' = free - (A_xy a_x + (lambda + A_yy) a_y) / D.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace

from phichain.ir.builder import ArrayRef, Builder, Expr, Index, Loop
from phichain.lowering.chain.link_units import LinkUnits
from phichain.lowering.chain.losses import push_on_cart
from phichain.lowering.chain.parameters import Parameters
from phichain.lowering.chain.room import saves_text
from phichain.lowering.planar.joints import PlanarState, couples, from_absolute
from phichain.scene import Scene

#: So many links at the tip stand outside the loop: the zeros beyond the tip save most of their operations.
_TIP_LINKS = 2


@dataclass(frozen=True)
class Outer:
    """The chain beyond a joint: inertia A, E / lambda, force b and k / lambda; E and k of rigid links."""

    xx: Expr
    xy: Expr
    yy: Expr
    determinant: Expr
    force_x: Expr
    force_y: Expr
    minor_x: Expr
    minor_y: Expr


@dataclass(frozen=True)
class Pivot:
    """What the elimination of a link leaves for the rest of its step."""

    rate_squared: Expr
    swing: Expr
    drive: Expr
    inverse: Expr
    free: Expr
    gain_x: Expr


def accelerations(
    builder: Builder, scene: Scene, parameters: Parameters, state: PlanarState, u: ArrayRef | None, a: ArrayRef
) -> None:
    """Write the accelerations [x'', theta''] into `a`."""
    sweep = Sweep(builder, scene, parameters, state, couples(builder, scene, parameters, state, u))
    outer = sweep.to_base()
    base_y = -parameters.fall[0]
    if scene.has_cart:
        force = push_on_cart(scene, parameters, u, state.speed)
        base_y = sweep.cart_acceleration(outer, force)
        a[0] = base_y * parameters.units.length
    sweep.all_outwards(-parameters.fall[1], base_y, a.shifted(int(scene.has_cart)))


class Sweep:
    """The inward elimination and the outward substitution; work arrays carry one to the other."""

    def __init__(
        self, builder: Builder, scene: Scene, parameters: Parameters, state: PlanarState, couple: ArrayRef | None
    ) -> None:
        self.builder, self.scene, self.parameters, self.state, self.couple = builder, scene, parameters, state, couple
        self.units = LinkUnits(builder, scene, parameters)
        self.factors = self.units.factors()
        self.rho_y = builder.array("turning_gain_y", scene.links) if self.units.is_rigid else None
        self.sine, self.cosine = builder.sincos(state.angle, scene.links)
        self.free, self.gain_x, self.gain_y, self.rate_squared = (
            builder.array(name, scene.links) for name in ("free", "gain_x", "gain_y", "rate_squared")
        )

    def to_base(self) -> Outer:
        """Eliminate all links; returns what a cart carries. Where text is dear, in a single loop."""
        if saves_text(self.scene):
            with self.builder.loop("k", self.scene.links - 1, -1, -1) as loop:
                before = self.carried(loop, self.beyond(self.scene.links))
                self.followed(loop, before, self.eliminate(before, loop.index))
            return before
        outer = self.inwards()
        if not self.scene.has_cart:
            self.pivot(outer, 0)
        return outer

    def inwards(self) -> Outer:
        """The chain beyond the cart, or beyond link 0 of a chain on a fixed base, which passes nothing on."""
        links, last = self.scene.links, 0 if self.scene.has_cart else 1
        inner = max(links - _TIP_LINKS, last)
        outer = self.beyond(inner)
        if inner == last:
            return outer
        with self.builder.loop("k", inner - 1, last - 1, -1) as loop:
            before = self.carried(loop, outer)
            self.followed(loop, before, self.eliminate(before, loop.index))
        return before

    def beyond(self, k: int) -> Outer:
        """Link k and all beyond it, seen from the link before, written out link by link."""
        outer = Outer(*(self.builder.lift(0) for _ in fields(Outer)))
        for link in range(self.scene.links - 1, k - 1, -1):
            outer = self.eliminate(outer, link)
        return outer

    def carried(self, loop: Loop, outer: Outer) -> Outer:
        """The same as scalars that a loop carries; E is zero throughout where every mass sits at its link's end."""
        kept = {"determinant"} if self.scene.tip_masses else set()
        named = {field.name: getattr(outer, field.name) for field in fields(Outer) if field.name not in kept}
        return replace(outer, **{name: loop.carry(f"outer_{name}", value) for name, value in named.items()})

    def followed(self, loop: Loop, before: Outer, after: Outer) -> None:
        """Say what they are on the next turn."""
        for name in (field.name for field in fields(Outer)):
            if name != "determinant" or not self.scene.tip_masses:
                loop.follow(getattr(before, name), getattr(after, name))

    def pivot(self, outer: Outer, k: Index) -> Pivot:
        """Eliminate the rotation of link k: its tip accelerates by free - gain_x a_x - gain_y a_y along its tangent."""
        let = self.builder.let
        rate_squared = let("rate_squared", self.state.rate[k] * self.state.rate[k])
        inverse = let("inverse_pivot", 1 / (1 + outer.yy))
        swing = let("swing", rate_squared * outer.xy)
        push = swing - outer.force_y
        drive = self.builder.lift(0)
        if self.couple is not None:
            drive = let("drive", self.couple[k] * self.units.inverse_torque[k])
        free = let("free", (drive + push) * inverse)
        gain_x = let("gain_x", outer.xy * inverse)
        self.rate_squared[k], self.free[k], self.gain_x[k] = rate_squared, free, gain_x
        self.gain_y[k] = self.units.overhang[k] * inverse
        if self.rho_y is not None:
            self.rho_y[k] = (self.units.leverage[k] + outer.yy) * inverse
        return Pivot(rate_squared, swing, drive, inverse, free, gain_x)

    def eliminate(self, outer: Outer, k: Index) -> Outer:
        """Link k and all beyond it, seen from the link before."""
        return self._turned(self.with_link(outer, self.pivot(outer, k), k), k)

    def with_link(self, outer: Outer, pivot: Pivot, k: Index) -> Outer:
        """Link k and all beyond it in the frame of link k, in units of the link before."""
        let, factors = self.builder.let, self.factors
        leverage, overhang = self.units.leverage[k], self.units.overhang[k]
        inverse, rate_squared, drive = pivot.inverse, pivot.rate_squared, pivot.drive
        across, along = self.lifted(outer.yy, k) + outer.determinant, self.lifted(outer.xx, k) + outer.determinant
        shared = overhang * outer.minor_x + self.lifted(outer.xy, k) * drive
        axial = let("axial", self.axial(outer, k) * inverse)
        determinant = self.determinant(outer, inverse, k)
        force_x = self.pulled(outer, drive, k) * inverse - rate_squared * (leverage + axial)
        force_y = let("link_force_y", drive + overhang * pivot.free)
        minor_x = (shared - overhang * (rate_squared * across)) * inverse
        minor_y = (drive * along - overhang * (outer.minor_y + self.lifted(pivot.swing, k))) * inverse
        return Outer(
            xx=let("link_xx", factors.axial[k] + factors.mass[k] * axial),
            xy=-(factors.skew[k] * pivot.gain_x),
            yy=let("link_yy", factors.lever[k] * (outer.yy * inverse)),
            determinant=let("link_determinant", factors.determinant[k] * determinant),
            force_x=let("link_force_x", factors.force[k] * force_x),
            force_y=factors.force[k] * force_y,
            minor_x=let("link_minor_x", factors.minor_x[k] * minor_x),
            minor_y=let("link_minor_y", factors.minor_force[k] * force_y + factors.minor[k] * minor_y),
        )

    def lifted(self, value: Expr, k: Index) -> Expr:
        """A value beside E and k: times lambda where these are carried as they are."""
        return self.units.leverage[k] * value if self.units.is_rigid else value

    def axial(self, outer: Outer, k: Index) -> Expr:
        """A_xx + E."""
        along = outer.xx + outer.determinant
        return along if self.units.is_rigid else along + self.units.overhang[k] * outer.determinant

    def determinant(self, outer: Outer, inverse: Expr, k: Index) -> Expr:
        """(lambda^2 A_yy + E) / D, over what E is carried over."""
        if self.units.is_rigid:
            return (self.units.leverage[k] * self.lifted(outer.yy, k) + outer.determinant) * inverse
        return ((outer.yy + outer.determinant) + self.units.overhang[k] * outer.yy) * inverse

    def pulled(self, outer: Outer, drive: Expr, k: Index) -> Expr:
        """b_x + k_x + tau A_xy."""
        whole = outer.xy * drive
        if not self.units.is_rigid:
            whole = self.units.overhang[k] * outer.minor_x + whole
        return outer.force_x + outer.minor_x + whole

    def _turned(self, link: Outer, k: Index) -> Outer:
        """The same in the frame of the link before; determinants do not change."""
        let, sine, cosine = self.builder.let, self.sine[k], self.cosine[k]
        shear = let("shear", sine * (link.xx - link.yy) + cosine * (link.xy + link.xy))
        lean = let("lean", sine * shear)
        return Outer(
            xx=let("outer_xx", link.xx - lean),
            xy=let("outer_xy", cosine * shear - link.xy),
            yy=let("outer_yy", link.yy + lean),
            determinant=link.determinant,
            force_x=let("outer_force_x", cosine * link.force_x - sine * link.force_y),
            force_y=let("outer_force_y", sine * link.force_x + cosine * link.force_y),
            minor_x=let("outer_minor_x", cosine * link.minor_x - sine * link.minor_y),
            minor_y=let("outer_minor_y", sine * link.minor_x + cosine * link.minor_y),
        )

    def cart_acceleration(self, outer: Outer, force: Expr) -> Expr:
        """(m_c + A_yy) x'' = u - b_y + g A_xy, in the units of the scene's parameters; m_c holds what rigid links leave there."""
        parameters, unit = self.parameters, self.units.mass_unit[0]
        push = force + parameters.gravity * (unit * outer.xy) - (unit * parameters.length[0]) * outer.force_y
        return self.builder.let("cart_acceleration", push / (parameters.base_mass + unit * outer.yy))

    def all_outwards(self, base_x: Expr, base_y: Expr, theta_ddot: ArrayRef) -> None:
        """From the base's acceleration to all others."""
        alpha = self.builder.array("acceleration", self.scene.links)
        inverse = 1 / self.parameters.length[0]
        with self.builder.loop("k", 0, self.scene.links) as loop:
            self.outwards(alpha, loop, (inverse * base_x, inverse * base_y), loop.index)
        from_absolute(self.builder, self.scene, alpha, theta_ddot)

    def moved(self, k: Index, joint_y: Expr, tip: tuple[Expr, Expr]) -> None:
        """What else is made of a link's accelerations: nothing."""

    def outwards(self, alpha: ArrayRef, loop: Loop, base: tuple[Expr, Expr], k: Index) -> tuple[Expr, Expr]:
        """One turn from a joint's acceleration to the next, in units of each link's length; what the turn begins with."""
        carried_x, carried_y = loop.carry("base_x", base[0]), loop.carry("base_y", base[1])
        following = self.outer_end(alpha, (carried_x, carried_y), k)
        loop.follow(carried_x, following[0])
        loop.follow(carried_y, following[1])
        return carried_x, carried_y

    def outer_end(self, alpha: ArrayRef, base: tuple[Expr, Expr], k: Index) -> tuple[Expr, Expr]:
        """The acceleration of link k, written into `alpha`, and of its outer end."""
        before_x, before_y = (self.units.outward[k] * axis for axis in base)
        joint_x = self.builder.let("joint_x", self.cosine[k] * before_x + self.sine[k] * before_y)
        joint_y = self.builder.let("joint_y", self.cosine[k] * before_y - self.sine[k] * before_x)
        return self.tip_of(alpha, (joint_x, joint_y), k)

    def tip_of(self, alpha: ArrayRef, joint: tuple[Expr, Expr], k: Index) -> tuple[Expr, Expr]:
        """The same from the joint's acceleration in the frame of the link."""
        (joint_x, joint_y), swung = joint, self.free[k] - self.gain_x[k] * joint[0]
        if self.rho_y is not None:
            swung = self.builder.let("swung", swung)
        tip_y = self.builder.let("tip_y", swung - self.gain_y[k] * joint_y)
        alpha[k] = tip_y - joint_y if self.rho_y is None else swung - self.rho_y[k] * joint_y
        tip = joint_x - self.rate_squared[k], tip_y
        self.moved(k, joint_y, tip)
        return tip
