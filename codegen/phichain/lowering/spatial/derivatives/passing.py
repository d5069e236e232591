"""How the links of a spatial chain pass small changes on, with masses anywhere on them (`spatial.mobilities`; theory, section 5).

A pair of forces g and -g on the ends of a link, and a change e of what its ends may differ by along q, move its outer end by

    da' = T da + alpha' e W q + H (g - df),      T = alpha' W q q^T - kappa H,
    H = W - alpha' W q (W q)^T = (hat(q) T_0 hat(q)^T + alpha x x^T) / D,     x = q x u,

da the change of its joint's acceleration and df that of the force which the chain beyond asks for; T_0 is what `spatial.mobilities` calls
T, D there q.adj(b I + A) q. A heavy chain beyond makes alpha u large and what it does small, so a force is kept in two parts, four numbers
F = (c, d) of df = alpha u c + d, as the sweep keeps f, and they pass on

    F' = P F + (e - W q.g, g + kappa W g),     P = [[q.W alpha u, (W q)^T], [-kappa W alpha u, -kappa W]],    W alpha u = alpha Q u / E.

By them the chain inside moves the joint by -Y F, Y = [y, Y_d] of three by four with

    Y' = T Y P + [H alpha u, H],     H alpha u = alpha hat(q) T_0 hat(q)^T u / D:

a wall has no Y, a cart that of its horizontal inertia. The last link has no end of its own in that form: beyond its joint it is
T = 1 - 1 / beta and H = 1 / b.
"""

from __future__ import annotations

from phichain.ir.builder import ArrayRef, Builder, Expr, Index
from phichain.lowering.algebra.matrix import (
    Matrix,
    applied,
    combine,
    dyads,
    hat,
    load_matrix,
    minus,
    outer,
    plus,
    product,
    scalar,
    scaled,
    store_matrix,
    symmetric,
    transposed,
    triangle,
)
from phichain.lowering.algebra.vector import Vector, dot, load, scale, store, sub
from phichain.lowering.chain.parameters import Parameters
from phichain.lowering.spatial.links import couples_of, joint_moments
from phichain.lowering.spatial.mobilities import Beyond, Pivot, Sweep
from phichain.lowering.spatial.rates import Rates
from phichain.scene import Scene


class Recalled(Sweep):
    """The sweep that keeps what derivatives need.

    `joint` holds the acceleration of every link's joint less gravity, `stretch` that of the chain beyond the joint, u.a + c, whose product
    with alpha is the tension, `freedom` H, `drawn` W alpha u, `drawn_freely` H alpha u, `moment` what joints transmit, `cart` the Y of
    joint 0. A light link before a heavy chain makes the stretch small:

        E (next u.a + c) = Q u.(s q - kappa a + p - d) + c det T
    """

    def __init__(self, builder: Builder, scene: Scene, parameters: Parameters, q: ArrayRef, rates: Rates) -> None:
        self.moment: ArrayRef | None = None
        super().__init__(builder, scene, parameters, q, rates)
        links = scene.links
        self.joint, self.stretch = builder.array("joint_acceleration", 3 * links), builder.array("stretch", links)
        self.seen, self.rest = builder.array("seen_over_whole", 3 * links), builder.array("stretch_rest", links)
        self.freedom = builder.array("freedom", 6 * links)
        self.drawn, self.drawn_freely = builder.array("drawn", 3 * links), builder.array("drawn_freely", 3 * links)
        self.cart: Matrix | None = None
        own = builder.lift(1) / self.scales.own[links - 1]
        self._free(links - 1, scalar(own))

    def couples(self) -> ArrayRef | None:
        """As the sweep, and keep the joints' moments."""
        self.moment = joint_moments(self.builder, self.scene, self.parameters, self.direction, self.rates.angular, self.rates.bend)
        return None if self.moment is None else couples_of(self.builder, self.scene, self.direction, self.moment)

    def outwards(self, base: Vector) -> None:
        """As the sweep, and keep the stretch of the whole chain."""
        self.stretch[0] = dot(load(self.stretch_axis, 0), base) + self.pull[0]
        super().outwards(base)

    def _free(self, k: Index, value: Matrix) -> None:
        for i, entry in enumerate(triangle(value)):
            self.freedom[6 * k + i] = entry

    def eliminated(self, chain: Beyond, k: Index, pivot: Pivot) -> None:
        """Keep H, H alpha u, W alpha u, and what the next link's stretch is made of."""
        turn = hat(self.builder, load(self.direction, k))
        turned = symmetric(triangle(product(product(turn, pivot.own), transposed(turn))))
        share = self.builder.let("inverse_axial_pivot", pivot.axial * pivot.inverse)
        heavy = self.builder.let("heavy_share", share * chain.axial)
        self._free(k, combine((share, turned), (heavy, dyads(pivot.across, pivot.across))))
        store(self.drawn_freely, k, scale(heavy, applied(turned, chain.direction)))
        seen = scale(pivot.inverse, pivot.seen)
        store(self.drawn, k, scale(chain.axial, seen))
        store(self.seen, k, seen)
        rest = chain.pull * (pivot.determinant * pivot.inverse)
        self.rest[k] = rest if pivot.push is None else rest + self.scales.scale[k] * dot(seen, pivot.push)

    def moved(self, k: Index, joint: Vector, stretched: Expr | None) -> None:
        """Keep the joint's acceleration and the stretch of all beyond it, u.a + c, of the next link without what cancels in it."""
        store(self.joint, k, joint)
        if stretched is None:
            return
        own = sub(scale(self.axial[k] * self.stretch[k], load(self.direction, k)), scale(self.scales.lever[k], joint))
        self.stretch[k + 1] = dot(load(self.seen, k), own) + self.rest[k]

    def closed(self, firm: Vector, axial: Expr, lean: tuple[Expr, Expr], inverse: Expr) -> None:
        """Keep the inverse of the cart's inertia, chain included, and before it what alpha u does."""
        (xx, xy, yy), (x, y), nothing = firm, lean, self.builder.lift(0)
        first, mixed, second = (yy + axial * (y * y)) * inverse, -((xy + axial * (x * y)) * inverse), (xx + axial * (x * x)) * inverse
        heavy = axial * inverse
        self.cart = (
            (heavy * (yy * x - xy * y), first, mixed, nothing), (heavy * (xx * y - xy * x), mixed, second, nothing),
            (nothing, nothing, nothing, nothing),
        )  # fmt: skip


class Passing:
    """T, P, H and Y of every link, and what rows of results make of them.

    Attributes:
        outwards: rows of a link's omega' per acceleration of its joint, hat(q) (T - 1) / l.
        inwards: the same per force that the chain beyond its end asks for, -(outwards Y P + hat(q) [H alpha u, H] / l).
        over_reach: 1 / beta of the last link.
    """

    def __init__(self, sweep: Recalled) -> None:
        self.builder, self.sweep, self.links = sweep.builder, sweep, sweep.scene.links
        builder, links = self.builder, self.links
        self.passes, self.forces = builder.array("passes", 9 * links), builder.array("passes_force", 16 * links)
        self.outwards, self.inwards = builder.array("rows_outwards", 9 * links), builder.array("rows_inwards", 12 * links)
        self.mobility = builder.array("joint_mobility", 12 * links)
        self.unit = builder.array("unit_over_length", 3 * links)
        self.over_reach = sweep.parameters.length[links - 1] / sweep.parameters.com[links - 1]
        self._fill()
        self._answer()

    def _fill(self) -> None:
        builder, sweep, last, one = self.builder, self.sweep, self.links - 1, self.builder.lift(1)
        with builder.loop("k", 0, self.links) as loop:
            k = loop.index
            store(self.unit, k, scale(sweep.inverse_length[k], load(sweep.direction, k)))
        with builder.loop("k", 0, last) as loop:
            k = loop.index
            axis, drawn = load(sweep.tension_axis, k), load(sweep.drawn, k)
            through = outer(scale(sweep.axial[k], axis), load(sweep.direction, k))
            store_matrix(self.passes, k, minus(through, scaled(sweep.scales.lever[k], self.freedom(k))))
            lower = zip(scale(-sweep.scales.lever[k], drawn), scaled(sweep.scales.lean[k], self.kept_mobility(k)), strict=True)
            store_matrix(self.forces, k, ((dot(load(sweep.direction, k), drawn), *axis), *((first, *rest) for first, rest in lower)))
        store_matrix(self.passes, last, scalar(1 - self.over_reach))
        with builder.loop("k", 0, last) as loop:
            k = loop.index
            store_matrix(self.outwards, k, product(self.turn(k), minus(self.passed(k), scalar(one))))
        store_matrix(self.outwards, last, scaled(-self.over_reach, self.turn(last)))

    def _answer(self) -> None:
        builder, sweep, nothing = self.builder, self.sweep, self.builder.lift(0)
        before = ((nothing,) * 4,) * 3 if sweep.cart is None else sweep.cart
        with builder.loop("k", 0, self.links - 1) as loop:
            k = loop.index
            carried = tuple(
                tuple(loop.carry(f"mobility_{row}{column}", entry) for column, entry in zip("cxyz", entries, strict=True))
                for row, entries in zip("xyz", before, strict=True)
            )
            back, free = product(carried, self.passed_force(k)), self.freed(k)
            here = plus(product(self.passed(k), back), free)
            store_matrix(self.mobility, k, here)
            store_matrix(self.inwards, k, scaled(-1, plus(product(load_matrix(self.outwards, k), back), product(self.turn(k), free))))
            for old_row, new_row in zip(carried, here, strict=True):
                for old, new in zip(old_row, new_row, strict=True):
                    loop.follow(old, new)

    def kept_mobility(self, k: Index) -> Matrix:
        """-mu W."""
        return symmetric([self.sweep.mobility[6 * k + i] for i in range(6)])

    def freedom(self, k: Index) -> Matrix:
        """H."""
        return symmetric([self.sweep.freedom[6 * k + i] for i in range(6)])

    def freed(self, k: Index) -> Matrix:
        """[H alpha u, H]"""
        return tuple((first, *rest) for first, rest in zip(load(self.sweep.drawn_freely, k), self.freedom(k), strict=True))

    def passed(self, k: Index) -> Matrix:
        """T."""
        return load_matrix(self.passes, k)

    def passed_force(self, k: Index) -> Matrix:
        """P."""
        return load_matrix(self.forces, k, 4)

    def at_joint(self, k: Index) -> Matrix | None:
        """Y of link k's joint; None on a wall."""
        if isinstance(k, int) and k == 0:
            return self.sweep.cart
        entries = [self.mobility[12 * (k - 1) + i] for i in range(12)]
        return tuple(tuple(entries[4 * i : 4 * i + 4]) for i in range(3))

    def turn(self, k: Index) -> Matrix:
        """hat(q) / l."""
        return hat(self.builder, load(self.unit, k))
