"""Where both sides meet, what carries the first link, and the way back to the base: the same for both shapes of the elimination."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace

from phichain.ir.builder import ArrayRef, Builder, Expr, Index, Loop
from phichain.lowering.chain.link_units import LinkUnits
from phichain.lowering.chain.parameters import Parameters
from phichain.lowering.planar.articulated import Outer
from phichain.lowering.planar.both_ends.base_side import Weight
from phichain.scene import Scene


@dataclass(frozen=True)
class Inner:
    """The chain between the base and a joint: mobility W, lambda^2 F, acceleration a0 and lambda h without the chain beyond."""

    xx: Expr
    xy: Expr
    yy: Expr
    determinant: Expr
    drift_x: Expr
    drift_y: Expr
    minor_x: Expr
    minor_y: Expr

    def carried(self, loop: Loop) -> Inner:
        """The same as scalars that a loop carries."""
        named = {field.name: getattr(self, field.name) for field in fields(Inner)}
        return Inner(**{name: loop.carry(f"mobility_{name}", value) for name, value in named.items()})


@dataclass(frozen=True)
class Met:
    """Force and acceleration at the outer end of a link, in its frame and units."""

    x_force: Expr
    y_force: Expr
    x: Expr
    y: Expr


def beginning(builder: Builder, scene: Scene, parameters: Parameters, units: LinkUnits, force: Expr) -> Inner:
    """What carries link 0: a wall, which may be given an acceleration, or a cart that yields to the side."""
    inverse, zero = 1 / parameters.length[0], builder.lift(0)
    wall = Inner(*(zero for _ in fields(Inner)))
    wall = replace(wall, drift_x=-parameters.fall[1] * inverse, drift_y=-parameters.fall[0] * inverse)
    if not scene.has_cart:
        return wall
    yielding = units.mass_unit[0] / parameters.base_mass
    return replace(
        wall, yy=yielding, drift_y=force * inverse / parameters.base_mass,
        minor_x=units.leverage[0] * yielding * wall.drift_x,
    )  # fmt: skip


def met(builder: Builder, units: LinkUnits, inner: Inner, outer: Outer, k: int) -> Met:
    """What the two sides do where they meet, below link k; worked out in its units, stated in those of the link before."""
    let = builder.let
    mass, length = units.mass[k], units.length[k]
    leverage, shortening = units.leverage[k], units.shortening[k]
    of_mass, of_length = 1 / mass, units.outward[k]
    of_force, minor = of_mass * of_length, of_mass * of_mass * (shortening * units.leverage[k - 1])
    xx, xy, yy = (value * of_mass for value in (outer.xx, outer.xy, outer.yy))
    shrunk = outer.determinant * minor
    force_x, force_y = (value * of_force for value in (outer.force_x, outer.force_y))
    minor_x, minor_y = (value * (minor * of_length) for value in (outer.minor_x, outer.minor_y))
    trace = xx * inner.xx + 2 * (xy * inner.xy) + yy * inner.yy
    inverse = let("inverse_meeting", 1 / (1 + trace + shrunk * inner.determinant * shortening))
    adjugate_x = leverage * (inner.yy * minor_x - inner.xy * minor_y)
    adjugate_y = leverage * (inner.xx * minor_y - inner.xy * minor_x)
    met_x = xx * inner.drift_x + xy * inner.drift_y + force_x + shrunk * inner.minor_x + adjugate_x
    met_y = xy * inner.drift_x + yy * inner.drift_y + force_y + shrunk * inner.minor_y + adjugate_y
    still_x = (yy * inner.minor_x - xy * inner.minor_y - inner.determinant * minor_x) * shortening
    still_y = (xx * inner.minor_y - xy * inner.minor_x - inner.determinant * minor_y) * shortening
    x = inner.drift_x - inner.xx * force_x - inner.xy * force_y + still_x
    y = inner.drift_y - inner.xy * force_x - inner.yy * force_y + still_y
    unit = mass * length * inverse
    scale = length * inverse
    return Met(
        let("met_force_x", unit * met_x), unit * met_y, let("met_x", scale * x), let("met_y", scale * y)
    )


@dataclass(frozen=True)
class WayBack:
    """From where the sides meet to the base: forces along the links and accelerations, by what the elimination kept of every link.

    Attributes:
        builder: where it is recorded.
        scene: the chain.
        parameters: its numbers.
        units: its links' units.
        weight: kappa, where it is needed.
        sine, cosine: of the joints' angles.
        rate_squared: of the links.
        overhang_squared: (lambda - 1)^2 of them.
        force: takes a force into the units of the link before.
        kept: 1 / D, what is left along the link, W_xy lambda^2 / D, and what stands before a_y and g_y; the couples if there are any.
    """

    builder: Builder
    scene: Scene
    parameters: Parameters
    units: LinkUnits
    weight: Weight | None
    sine: ArrayRef
    cosine: ArrayRef
    rate_squared: ArrayRef
    overhang_squared: ArrayRef
    force: ArrayRef
    kept: dict[str, ArrayRef]

    def step(self, end: Met, alpha: ArrayRef, k: Index) -> Met:
        """Write the angular acceleration of link k; returns what the outer end of the link before does."""
        let = self.builder.let
        kept = {name: cells[k] for name, cells in self.kept.items()}
        push = self.units.overhang[k] * end.y
        if "drive" in kept:
            push = kept["drive"] + push
        joint_x = let("inner_x", end.x + self.rate_squared[k])
        pull = end.x_force if self.weight is None else end.x_force - self.weight.own[k] * joint_x
        rest = let("rest", kept["rest_push"] - kept["rest"] * pull)
        joint_y = let("inner_y", rest - kept["rest_across"] * push)
        alpha[k] = end.y - joint_y
        force_y = let("inner_force_y", self.overhang_squared[k] * rest + kept["rest_force"] * push)
        force_x = let(
            "inner_force_x", kept["yield"] * end.x_force + kept["reach"] - kept["coupling_skew"] * force_y
        )
        sine, cosine, length = self.sine[k], self.cosine[k], self.units.length[k]
        unit = self.force[k]
        return Met(
            let("end_force_x", unit * (cosine * force_x - sine * force_y)), unit * (sine * force_x + cosine * force_y),
            let("inner_end_x", length * (cosine * joint_x - sine * joint_y)),
            let("inner_end_y", length * (sine * joint_x + cosine * joint_y)),
        )  # fmt: skip

    def cart_acceleration(self, inner: Met, force: Expr) -> Expr:
        """The acceleration of the base across the vertical, from the joint there: zero on a wall."""
        if not self.scene.has_cart:
            return self.builder.lift(0)
        unit, parameters = self.units.mass_unit[0], self.parameters
        # With u - f_y = m_c x'' goes x'' = t_y, weighed by the heavier of what a light cart carries.
        weight = unit if self.weight is None else unit * (1 + self.weight.own[0])
        push = force + parameters.length[0] * (weight * inner.y - unit * inner.y_force)
        return self.builder.let("cart_acceleration", push / (parameters.base_mass + weight))
