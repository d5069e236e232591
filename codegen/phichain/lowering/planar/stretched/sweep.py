"""The articulated sweep with the stretch of the chain beyond handed outwards (docs/theory.md, section 5).

Heavy links on light, long ones keep a joint nearly where it falls: its acceleration, taken from those of the links before it, is
a small difference of large numbers, which a short link beyond divides by its length. With A, E, b and k of `articulated` in the
frame of link k, before it is turned, the link and all beyond it ask for f_x = A_xx y along its axis,

    y = a_x + nu a_y + C,   nu = A_xy / A_xx,   C = b_x / A_xx,   gamma = E / A_xx,   delta = k_y / A_xx

and handed outwards are y and a_y. With A, b and D of the chain beyond link k, in units of that link,

    t_x = y - nu a_y - e,   e = C + w^2 = ((b_x + k_x + tau A_xy) / D + lambda (lambda - 1) w^2) / (lambda^2 + (A_xx + E) / D)
    D t_y = ((lambda^2 + A_xx) (tau - (lambda - 1) a_y) + lambda (lambda - 1) w^2 A_xy - k_y - lambda^2 b_y)
            / (lambda^2 + (A_xx + E) / D) - A_xy y

are what its outer end does: tau - b_y - A_xy t_x - (lambda - 1) a_y with t_x put in, since A_xy would multiply a difference
where links are nearly in line. With s, c the sine and cosine of the next joint, nu, gamma, C and delta the next link's,
P = (1 + gamma) c - nu s and o = s + nu c,

    D y' = P y + ((lambda^2 o + gamma s) (tau - (lambda - 1) a_y) + C (lambda^2 (1 + gamma c^2) + gamma s^2)
                  + delta (s (c - nu s) - lambda^2 c o) - lambda (lambda - 1) w^2 P) / (lambda^2 + (A_xx + E) / D)

in which the large A_xx of the next link is in denominators alone: it cancels by hand, since A = A_xx u u^T + gamma p p^T and
b = A_xx C u + delta p, of vectors with u_x p_y - u_y p_x = 1. Where t_x is no difference, below a wall or a cart,

    D y' = P t_x + o (tau - delta c - (lambda - 1) a_y) + C (1 + gamma c^2)

serves; a cart is a link with its mass for 1, u for tau and no lambda - 1.
"""

from __future__ import annotations

from phichain.ir.builder import ArrayRef, Builder, Expr, Index
from phichain.lowering.chain.losses import push_on_cart
from phichain.lowering.chain.parameters import Parameters
from phichain.lowering.planar.articulated import Outer, Pivot, Sweep
from phichain.lowering.planar.joints import PlanarState, couples, from_absolute
from phichain.scene import Scene

#: y, a_y, t_x and t_y of a link.
End = tuple[Expr, Expr, Expr, Expr]

_KEPT = ("lean", "area", "pull", "push", "shift", "rest", "drive", "inverse", "axial", "yielding")


def accelerations(
    builder: Builder, scene: Scene, parameters: Parameters, state: PlanarState, u: ArrayRef | None, a: ArrayRef
) -> None:
    """Write the accelerations [x'', theta''] of a chain of points into `a`."""
    sweep = _Sweep(builder, scene, parameters, state, couples(builder, scene, parameters, state, u))
    outer = sweep.to_base()
    base_x, base_y, stretch = -parameters.fall[1], -parameters.fall[0], None
    inverse_length = 1 / parameters.length[0]
    if scene.has_cart:
        force = push_on_cart(scene, parameters, u, state.speed)
        base_y = sweep.cart_acceleration(outer, force)
        a[0] = base_y * parameters.units.length
        stretch = sweep.cart_stretch(outer, force)
    alpha = builder.array("acceleration", scene.links)
    sweep.from_base(alpha, (inverse_length * base_x, inverse_length * base_y), stretch)
    from_absolute(builder, scene, alpha, a.shifted(int(scene.has_cart)))


class _Sweep(Sweep):
    """The sweep of `articulated` inwards, which keeps nu, gamma, C, delta, e, (tau - b_y) / D, tau, 1 / D and 1 / A_xx of every link."""

    def __init__(
        self, builder: Builder, scene: Scene, parameters: Parameters, state: PlanarState, couple: ArrayRef | None
    ) -> None:
        super().__init__(builder, scene, parameters, state, couple)
        self.kept = {name: builder.array(f"kept_{name}", scene.links) for name in _KEPT}
        leverage, overhang = self.units.leverage, self.units.overhang
        self.squared = parameters.derived("leverage_squared", lambda k: leverage[k] * leverage[k])
        self.lever = parameters.derived("leverage_overhang", lambda k: leverage[k] * overhang[k])
        self.minor_unit = parameters.derived("leverage_before", lambda k: leverage[k - 1] if k else leverage[0])

    def pivot(self, outer: Outer, k: Index) -> Pivot:
        found = super().pivot(outer, k)
        self.kept["drive"][k], self.kept["inverse"][k] = found.drive, found.inverse
        return found

    def with_link(self, outer: Outer, pivot: Pivot, k: Index) -> Outer:
        link = super().with_link(outer, pivot, k)
        kept, let = self.kept, self.builder.let
        inverse = let("inverse_axial", 1 / link.xx)
        minor = let("minor_over_axial", self.minor_unit[k] * inverse)
        kept["lean"][k], kept["pull"][k] = link.xy * inverse, link.force_x * inverse
        kept["area"][k], kept["push"][k] = link.determinant * minor, link.minor_y * minor
        shift = self.pulled(outer, pivot.drive, k) * pivot.inverse + self.lever[k] * pivot.rate_squared
        kept["axial"][k] = axial = let("inverse_own_axial", self.factors.mass[k] * inverse)
        kept["shift"][k] = shift * axial
        squared, leverage = self.squared[k], self.units.leverage[k]
        over = let("inverse_both", axial * pivot.inverse)
        borne = let("borne", (squared + outer.xx) * over)
        rest = self.lever[k] * pivot.swing - leverage * outer.minor_y - squared * outer.force_y
        kept["rest"][k] = pivot.drive * borne + rest * over
        kept["yielding"][k] = self.units.overhang[k] * borne
        return link

    def cart_stretch(self, outer: Outer, force: Expr) -> Expr:
        """y of link 0 on a cart, in its units."""
        parameters, unit = self.parameters, self.units.mass_unit[0]
        inverse_length, mass = 1 / parameters.length[0], parameters.base_mass
        still = -(inverse_length * parameters.fall[1])
        pushed = self._stretch(0, (mass, unit), still, inverse_length * force)
        return self.builder.let("cart_stretch", pushed / (mass + unit * outer.yy))

    def from_base(self, alpha: ArrayRef, base: tuple[Expr, Expr], stretch: Expr | None) -> None:
        """From the base's acceleration, in lengths of link 0, to all angular ones; a wall has no stretch."""
        first, end = self._first(alpha, base, stretch)
        names = ("stretch_before", "joint_before", "end_x", "end_y")
        with self.builder.loop("k", first, self.scene.links) as loop:
            k = loop.index
            carried = [loop.carry(name, value) for name, value in zip(names, end, strict=True)]
            joint_y = self._joint(k, carried[2], carried[3])
            after = self._moved(alpha, k, self._handed(k, carried[0], carried[1]), joint_y)
            for before, value in zip(carried, after, strict=True):
                loop.follow(before, value)

    def _first(self, alpha: ArrayRef, base: tuple[Expr, Expr], stretch: Expr | None) -> tuple[int, End]:
        """What the links do that stand before the loop, and how many they are: link 0, and link 1 below a wall."""
        let, kept, sine, cosine = self.builder.let, self.kept, self.sine, self.cosine
        joint_y = let("joint_y", cosine[0] * base[1] - sine[0] * base[0])
        if stretch is not None:
            return 1, self._moved(alpha, 0, stretch, joint_y)
        joint_x = let("joint_x", cosine[0] * base[0] + sine[0] * base[1])
        tip_x = let("tip_x", joint_x - self.rate_squared[0])
        tip_y = let("tip_y", self.free[0] - self.gain_x[0] * joint_x - self.gain_y[0] * joint_y)
        alpha[0] = tip_y - joint_y
        one, push = self.builder.lift(1), kept["drive"][0] - self.units.overhang[0] * joint_y
        pushed = self._stretch(1, (one, one), tip_x, push)
        stretch = let("stretch", self.units.outward[1] * (pushed * kept["inverse"][0]))
        return 2, self._moved(alpha, 1, stretch, self._joint(1, tip_x, tip_y))

    def _joint(self, k: Index, x: Expr, y: Expr) -> Expr:
        """a_y of link k, of what the outer end of the link before does."""
        return self.builder.let("joint_y", self.units.outward[k] * (self.cosine[k] * y - self.sine[k] * x))

    def _moved(self, alpha: ArrayRef, k: Index, stretch: Expr, joint_y: Expr) -> End:
        """y, a_y, t_x and t_y of link k; writes its angular acceleration."""
        tip_x = self.builder.let("tip_x", stretch - self.kept["lean"][k] * joint_y - self.kept["shift"][k])
        return stretch, joint_y, tip_x, self._across(alpha, k, stretch, joint_y)

    def _handed(self, k: Index, stretch: Expr, joint_y: Expr) -> Expr:
        """y of link k, of y and a_y of the link before."""
        let, kept, sine, cosine = self.builder.let, self.kept, self.sine[k], self.cosine[k]
        lean, area, pull, push = (kept[name][k] for name in ("lean", "area", "pull", "push"))
        squared, before = self.squared[k - 1], k - 1
        shrunk = let("area_along", area * cosine)
        along, across = let("axis_x", cosine - lean * sine), let("axis_y", sine + lean * cosine)
        whole = let("stretch_gain", along + shrunk)
        tilted = let("area_across", area * sine)
        pushed = (squared * across + tilted) * (kept["drive"][before] - self.units.overhang[before] * joint_y)
        pushed = pushed + pull * (squared * (1 + shrunk * cosine) + tilted * sine)
        pushed = pushed + push * (sine * along - squared * (cosine * across))
        pushed = pushed - self.lever[before] * (self.rate_squared[before] * whole)
        handed = whole * stretch + pushed * kept["axial"][before]
        return let("stretch", self.units.outward[k] * (handed * kept["inverse"][before]))

    def _stretch(self, k: Index, mass: tuple[Expr, Expr], x: Expr, push: Expr) -> Expr:
        """D y of link k, carried by a mass that is pushed across x and accelerates by x along it; that mass, and what gamma goes with."""
        let, kept, sine, cosine = self.builder.let, self.kept, self.sine[k], self.cosine[k]
        own, unit = mass
        lean, shrunk = kept["lean"][k], let("area_along", unit * (kept["area"][k] * cosine))
        along = own * (cosine - lean * sine) + shrunk
        yielding = push - unit * (kept["push"][k] * cosine)
        return let("stretch", along * x + (sine + lean * cosine) * yielding + kept["pull"][k] * (own + shrunk * cosine))

    def _across(self, alpha: ArrayRef, k: Index, stretch: Expr, joint_y: Expr) -> Expr:
        """t_y; writes the angular acceleration of link k."""
        tip_y = self.builder.let("tip_y", self.kept["rest"][k] - self.gain_x[k] * stretch - self.kept["yielding"][k] * joint_y)
        alpha[k] = tip_y - joint_y
        return tip_y
