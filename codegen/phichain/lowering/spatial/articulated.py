"""Spatial forward dynamics with masses anywhere on their links: an articulated sweep on unit vectors.

The chain beyond a joint is carried as `spatial.outer` has it. A link of direction q, beta = r / l, rate w and couple n (of
springs and dampers), in units m of mass and l of length, turns as q'' = t - w^2 q with

    (beta^2 P + Gamma) t = n - P (f - w^2 A q) - P A q (q.a) - (beta P + Gamma) a,   Gamma = P A P, and is eliminated:
    D = det(beta^2 P + Gamma) = beta^4 + beta^2 tr Gamma + K_qq,   R = (beta^2 P + Gamma)^-1 = (beta^2 P + turned(A)) / D
    sigma = R P A q = P (beta^2 A - K) q / D,   eta = R f,   mu = R n
    X = (beta^4 q.A q + beta^2 tr P K P + E) / D,   alpha' = 1 + X,   nu' = -beta (1 - beta) sigma / alpha'
    G' = (1 - beta)^2 (beta^2 (Gamma + turned(K)) + (K_qq + E) P) / (alpha' D),   o' = q
    g' = (1 - beta)^4 (K_qq + E) / (alpha' D)
    alpha' c' = c (X q.o + beta^2 sigma.o) + q.(beta^4 d + beta^2 (tr A - A) d + K d) / D - w^2 (beta + X) + sigma.n
    d' = n + beta (1 - beta) (mu - (eta - (1 - beta) w^2 sigma + (beta^2 Y + A Y) x q / D - (sigma.n) sigma) / alpha')
    rho' = (1 - beta)^2 (-beta (1 - beta) P (turned(A) f + K f + (1 - beta) w^2 K q)
                         + beta P (turned(A) + K) n + (K_qq + E) n) / (alpha' D)

Outwards goes, beside the joint's acceleration a, what it stretches the chain by, y = u'.a + c' with u' = q + nu' and c' of this
link: the force along q over alpha'. A light link before this one makes a large across u' and leaves y alone, so y is never a
difference of large numbers:

    z = q.a - w^2 = y - nu'.a - e,   e = c' + w^2, formed as its sum
    next a = mu - eta + (q - sigma) z - beta (1 - beta) R a,   omega' = q x (next a - a)
    D (next y) = (beta^2 u.(beta^2 + tr G - G) q + g q.o) z - beta (1 - beta) k.a + k.n
                 + c (beta^4 + beta^2 tr P G P + g (q.o)^2) - k.d,   k = (beta^2 P + turned(A)) u = beta^2 P u - q x G x.

A cart closes the chain as a link of direction e_3 would: (m_c P + Gamma) x'' = u - P f + g P A e_3.
"""

from __future__ import annotations

from dataclasses import dataclass

from phichain.ir.builder import ArrayRef, Builder, Expr, Index
from phichain.lowering.algebra.matrix import Matrix, applied, combine, dyads, symmetric, triangle
from phichain.lowering.algebra.vector import Vector, add, cross, dot, load, scale, store, sub
from phichain.lowering.chain.losses import push_on_cart
from phichain.lowering.chain.parameters import Parameters
from phichain.lowering.spatial.links import couples, directions
from phichain.lowering.spatial.outer import Outer, Seen
from phichain.lowering.spatial.rates import Rates
from phichain.lowering.spatial.units import SpatialUnits, squares_loss
from phichain.scene import Scene

#: So many links at the tip stand outside the loop: the zeros beyond the tip save most of their operations.
_TIP_LINKS = 2


@dataclass(frozen=True)
class _Pivot:
    """What the elimination of a link leaves for the rest of its step; without couples `drive` and `yielding` are None."""

    inverse: Expr
    rate_squared: Expr
    sigma: Vector
    eta: Vector
    drive: Vector | None
    turned_drive: Vector | None
    yielding: Vector | None


def accelerations(
    builder: Builder, scene: Scene, parameters: Parameters, q: ArrayRef, rates: Rates, u: ArrayRef | None
) -> None:
    """Write x'' and the omega_k' through `rates`."""
    sweep = Sweep(builder, scene, parameters, q, rates)
    chain = sweep.inwards()
    nothing = builder.lift(0)
    base: Vector = tuple(-entry for entry in parameters.fall)
    if scene.has_cart:
        unit = parameters.units
        first, second = (push_on_cart(scene, parameters, u, rates.cart(), axis) for axis in (0, 1))
        force = (first, second, nothing)
        x, y, _ = sweep.close_on_cart(chain, force)
        rates.write_cart((x * unit.length, y * unit.length))
        base = (x, y, base[2])
        sweep.outwards(base, chain)
    else:
        sweep.pivot(sweep.seen(chain, 0), 0)
        store(sweep.lean, 0, (nothing, nothing, nothing))
        sweep.still_stretch[0] = sweep.rates.squared(0)
        sweep.outwards(base, None)


class Sweep:
    """The inward elimination and the outward substitution; work arrays carry one to the other."""

    def __init__(
        self, builder: Builder, scene: Scene, parameters: Parameters, q: ArrayRef, rates: Rates
    ) -> None:
        self.builder, self.scene, self.parameters = builder, scene, parameters
        self.direction, self.rates = directions(scene, q), rates
        self.couple = couples(builder, scene, parameters, self.direction, rates.angular, rates.bend)
        self.units = SpatialUnits(builder, scene, parameters)
        self.keeps_dyad = squares_loss(scene)
        self.free = builder.array("free", 3 * scene.links)
        self.slope = builder.array("slope", 3 * scene.links)
        self.freed = builder.array("freed", scene.links)
        self.gain = builder.array("gain", 6 * scene.links)
        self.lean = builder.array("lean", 3 * scene.links)
        self.still_stretch = builder.array("still_stretch", scene.links)
        self.stretch_share = builder.array("stretch_share", scene.links)
        self.stretch_free = builder.array("stretch_free", scene.links)
        self.stretch_gain = builder.array("stretch_gain", 3 * scene.links)

    def inwards(self) -> Outer:
        """The chain beyond the cart, or beyond link 0 of a chain on a fixed base, which passes nothing on."""
        links, last = self.scene.links, 0 if self.scene.has_cart else 1
        nothing = self.builder.lift(0)
        chain = Outer.from_flat([nothing] * 21)
        inner = max(links - (_TIP_LINKS + int(self.keeps_dyad)), last)
        for k in range(links - 1, inner - 1, -1):
            chain = self.eliminate(chain, k)
        if inner == last:
            return chain
        with self.builder.loop("k", inner - 1, last - 1, -1) as loop:
            carried = [loop.carry("outer", value) for value in chain.flat()]
            following = self.eliminate(Outer.from_flat(carried), loop.index)
            for before, after in zip(carried, following.flat(), strict=True):
                loop.follow(before, after)
        return Outer.from_flat(carried)

    def seen(self, chain: Outer, k: Index) -> Seen:
        """The chain beyond link k as that link meets it."""
        return Seen(chain, load(self.direction, k), self.units.reach_squared[k])

    def pivot(self, seen: Seen, k: Index) -> _Pivot:
        """Eliminate the rotation of link k: its tip's a = free + slope z - freed gain a, and what the tip stretches."""
        own = seen.own
        inverse = self.builder.let("inverse_pivot", 1 / (own * (own + seen.trace) + seen.adjugate_axial))
        held = own * inverse
        rate_squared = self.builder.let("rate_squared", self.rates.squared(k))
        sigma = sub(scale(held, seen.mixed), scale(inverse, seen.adjugate_mixed))
        eta = add(scale(held, seen.force), scale(inverse, seen.turned_force))
        free = scale(-1, eta)
        stretch_free = seen.free_u
        drive = turned_drive = yielding = None
        if self.couple is not None:
            drive = scale(self.units.inverse_torque[k], load(self.couple, k))
            turned_drive = seen.turned(drive)
            yielding = add(scale(held, drive), scale(inverse, turned_drive))
            free = sub(yielding, eta)
            stretch_free = stretch_free + dot(seen.yielding_u, drive)
        # turned(A) = alpha x x^T + turned(G), turned(G) = tr(P G P) P - P G P
        gain = combine(
            (seen.across_trace, seen.projector),
            (1, dyads(scale(seen.outer.axial, seen.x), seen.x)), (-1, seen.tangent),
        )  # fmt: skip
        self.stretch_share[k], self.stretch_free[k] = inverse * seen.share, inverse * stretch_free
        self.freed[k] = self.units.lever[k] * inverse
        store(self.stretch_gain, k, seen.yielding_u)
        store(self.free, k, free)
        store(self.slope, k, sub(seen.q, sigma))
        for i, entry in enumerate(triangle(gain)):
            self.gain[6 * k + i] = entry
        return _Pivot(inverse, rate_squared, sigma, eta, drive, turned_drive, yielding)

    def eliminate(self, chain: Outer, k: Index) -> Outer:
        """Link k and all beyond it, in the units of the link before."""
        seen = self.seen(chain, k)
        pivot = self.pivot(seen, k)
        units, own, overhang = self.units, seen.own, self.units.overhang[k]
        added = self.builder.let(
            "axial", (own * (own * seen.axial + seen.adjugate_trace) + seen.determinant) * pivot.inverse
        )
        axial = 1 + added
        inverse_axial = self.builder.let("inverse_axial", 1 / axial)
        passed = units.overhang_squared[k] * (pivot.inverse * inverse_axial)
        planar = seen.adjugate_axial + seen.determinant
        mass, length = units.mass[k], units.length[k]
        passed_mass = mass * passed
        lean = scale(-(units.lever[k] * inverse_axial), pivot.sigma)
        drawn = self._drawn(seen, pivot, added)
        store(self.lean, k, lean)
        self.still_stretch[k] = (drawn + overhang * pivot.rate_squared) * inverse_axial
        return Outer(
            direction=seen.q,
            axial=mass * axial,
            lean=lean,
            tangent=combine((passed_mass * own, self._tangent(seen)), (passed_mass * planar, seen.projector)),
            area=mass * mass * (units.overhang_squared[k] * (passed * planar)),
            pull=length * ((drawn - pivot.rate_squared * (units.reach[k] + added)) * inverse_axial),
            push=scale(mass * length, self._push(seen, pivot, k, inverse_axial)),
            minor=self._minor(seen, pivot, k, mass * length * passed_mass, planar),
            dyad=(passed_mass * own * chain.axial, seen.tangent_u) if self.keeps_dyad and k == self.scene.links - 2 else None,
        )

    def _tangent(self, seen: Seen) -> Matrix:
        """Gamma + turned(K)."""
        axial = seen.outer.axial
        pressed = scale(axial * seen.along_u, seen.pressed)
        heavy = sub(scale(axial * (1 + seen.tangent_qq), seen.tangent_u), pressed)
        straight = dyads(seen.tangent_u, heavy, scale(-1, pressed), seen.tangent_u)
        flat = dyads(scale(seen.outer.area, seen.across_o), seen.across_o)
        lifted = 1 + axial * (seen.along_u * seen.along_u)
        return combine((1, straight), (lifted, seen.tangent), (1, flat))

    def _drawn(self, seen: Seen, pivot: _Pivot, added: Expr) -> Expr:
        """alpha' c' but for the own rate."""
        along = added * seen.along_o + seen.own * dot(pivot.sigma, seen.outer.direction)
        pull = seen.outer.pull * along + seen.axial_push * pivot.inverse
        return pull if pivot.drive is None else pull + dot(pivot.sigma, pivot.drive)

    def _push(self, seen: Seen, pivot: _Pivot, k: Index, inverse_axial: Expr) -> Vector:
        """d'."""
        lever, turning = self.units.lever[k], self.units.overhang[k] * pivot.rate_squared
        if pivot.drive is not None:
            turning = turning + dot(pivot.sigma, pivot.drive)
        held = sub(pivot.eta, scale(turning, pivot.sigma))
        held = add(held, scale(pivot.inverse, seen.crossed))
        if pivot.drive is None or pivot.yielding is None:
            return scale(-(lever * inverse_axial), held)
        return add(pivot.drive, scale(lever, sub(pivot.yielding, scale(inverse_axial, held))))

    def _minor(self, seen: Seen, pivot: _Pivot, k: Index, passed: Expr, planar: Expr) -> Vector:
        """rho', with `passed` = (1 - beta)^2 / (alpha' D) and `planar` = K_qq + E."""
        reach, overhang = self.units.reach[k], self.units.overhang[k]
        held = add(seen.turned_force, seen.adjugate_force)
        held = add(held, scale(overhang * pivot.rate_squared, seen.adjugate_mixed))
        if pivot.drive is None or pivot.turned_drive is None:
            return scale(-(self.units.lever[k] * passed), held)
        driven = add(pivot.turned_drive, seen.adjugate(pivot.drive))
        turned = scale(reach * passed, sub(driven, scale(overhang, held)))
        return add(turned, scale(passed * planar, pivot.drive))

    def close_on_cart(self, chain: Outer, force: Vector) -> Vector:
        """(m_c P + Gamma) x'' = u - P f + g P A e_3, seen from e_3; its inverse is (m_c P + turned(A)) / det."""
        parameters, nothing = self.parameters, self.builder.lift(0)
        seen = Seen(chain, (nothing, nothing, self.builder.lift(1)), nothing)
        mass, length = self.units.mass_unit[0], parameters.length[0]
        cart, gravity = parameters.base_mass / mass, parameters.gravity / length
        inverse = self.builder.let(
            "inverse_cart_pivot", 1 / (cart * cart + cart * seen.trace + seen.adjugate_axial)
        )
        given = scale(1 / (mass * length), force)
        push = add(sub(given, seen.force), scale(gravity, seen.mixed))
        turned = sub(sub(seen.turned(given), seen.turned_force), scale(gravity, seen.adjugate_mixed))
        x, y, _ = scale(length * inverse, add(scale(cart, push), turned))
        return self.builder.let("cart_acceleration_0", x), self.builder.let("cart_acceleration_1", y), nothing

    def stretched(self, k: Index, stretch: Expr) -> None:
        """What else is made of what a joint's acceleration stretches link k and all beyond by, on the way outwards: nothing."""

    def outwards(self, base: Vector, chain: Outer | None) -> None:
        """omega_k' = q_k x t_k, and on to the next joint, in units of each link's length."""
        builder, units = self.builder, self.units
        start = scale(1 / self.parameters.length[0], base)
        with builder.loop("k", 0, self.scene.links) as loop:
            k = loop.index
            x, y, z = start
            carried = (loop.carry("joint_x", x), loop.carry("joint_y", y), loop.carry("joint_z", z))
            stretch = loop.carry("stretch", self._first_stretch(chain, start))
            self.stretched(k, stretch)
            joint, q = scale(units.outward[k], carried), load(self.direction, k)
            axial = units.outward[k] * stretch - dot(load(self.lean, k), joint) - self.still_stretch[k]
            first, second = load(self.gain, 2 * k), load(self.gain, 2 * k + 1)
            tip = add(load(self.free, k), scale(axial, load(self.slope, k)))
            tip = sub(tip, scale(self.freed[k], applied(symmetric((*first, *second)), joint)))
            self.rates.write(k, cross(q, sub(tip, joint)))
            for before, after in zip(carried, tip, strict=True):
                loop.follow(before, after)
            drawn = self.freed[k] * dot(load(self.stretch_gain, k), joint)
            loop.follow(stretch, self.stretch_share[k] * axial + self.stretch_free[k] - drawn)

    def _first_stretch(self, chain: Outer | None, start: Vector) -> Expr:
        """u.a + c of link 0."""
        if chain is None:
            return dot(load(self.direction, 0), start)
        return dot(add(chain.direction, chain.lean), start) + chain.pull
