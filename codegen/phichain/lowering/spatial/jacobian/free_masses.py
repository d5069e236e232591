"""The answers of a spatial chain with its masses anywhere on their links, from the sweep of `spatial.mobilities`."""

from __future__ import annotations

from phichain.ir.builder import ArrayRef, Builder, Expr, Index
from phichain.lowering.algebra.matrix import Matrix, minus, outer, scaled, symmetric, triangle
from phichain.lowering.algebra.vector import Vector, cross, dot, load, scale, store, zeros
from phichain.lowering.parameters import Parameters
from phichain.lowering.spatial.jacobian.response import Link
from phichain.lowering.spatial.mobilities import Sweep
from phichain.lowering.spatial.rates import Rates
from phichain.scene import Scene


class FreeMasses(Sweep):
    """The sweep that keeps what derivatives need, the last link's with that of the others."""

    rank = 3

    def __init__(self, builder: Builder, scene: Scene, parameters: Parameters, q: ArrayRef, rates: Rates) -> None:
        super().__init__(builder, scene, parameters, q, rates, scene.links)
        self.multiplier = builder.array("multiplier", scene.links)
        tip, scales = scene.links - 1, self.scales
        own, here, nothing = scales.own[tip], load(self.direction, tip), builder.lift(0)
        self.axial[tip] = own
        store(self.tension_axis, tip, scale(1 / own, here))
        store(self.stretch_axis, tip, scale(1 + scales.lever[tip] / own, here))
        free = -(scales.scale[tip] / own)
        self.free = symmetric((free, nothing, nothing, free, nothing, free))
        store(self.mobility, tip, triangle(self.free))

    def link(self, k: Index) -> Link:
        """The answers of link k."""
        q, inverse, scales = load(self.direction, k), self.inverse_length[k], self.scales
        axial, axis = self.axial[k], load(self.tension_axis, k)
        mobility = self._mobility(k)
        held = minus(scaled(-(1 / scales.scale[k]), mobility), outer(scale(axial, axis), axis))
        turned = scale(inverse, cross(q, axis))
        carried = scaled(scales.lean[k], mobility)
        return Link(q, inverse, axial, axis, load(self.stretch_axis, k), turned, held, carried, self.multiplier[k])

    def _mobility(self, k: Index) -> Matrix:
        """-mu W; the last link's has zeros that are known."""
        last = isinstance(k, int) and k == self.scene.links - 1
        return self.free if last else symmetric(load(self.mobility, k, 6))

    def turned_before(self, k: Index) -> Vector:
        """J_k w_{k-1}, which a P of full rank does without."""
        return zeros(self.builder, 3)

    def base(self, cart_mass: Expr) -> Matrix:
        """Omega of the base of a chain on a cart: the inverse of m_c I + alpha v v^T + G, all horizontal."""
        scales, axial, nothing = self.scales, self.axial[0], self.builder.lift(0)
        x, y, _ = load(self.stretch_axis, 0)
        (xx, xy, _), (_, yy, _), _ = self._mobility(0)
        firm, slack = cart_mass + scales.base_overhang, scales.base_slack
        xx, xy, yy = firm + slack * xx, slack * xy, firm + slack * yy
        heavy = x * (yy * x - xy * y) + y * (xx * y - xy * x)
        inverse = self.builder.let("inverse_base_pivot", 1 / ((xx * yy - xy * xy) + axial * heavy))
        rows = symmetric((yy + axial * (y * y), -(xy + axial * (x * y)), nothing, xx + axial * (x * x), nothing, nothing))
        return scaled(inverse, rows)

    def _keep(self, k: Index, multiplier: Expr) -> None:
        self.multiplier[k] = multiplier

    def _turn_tip(self, joint: Vector) -> None:
        """Its multiplier too: alpha (v.a - l w^2)."""
        super()._turn_tip(joint)
        tip = self.scene.links - 1
        stretched = dot(load(self.stretch_axis, tip), joint) - self.parameters.length[tip] * self.rates.squared(tip)
        self.multiplier[tip] = self.axial[tip] * stretched
