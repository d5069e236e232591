"""Spatial forward dynamics with masses anywhere on their links where no mass is beside a much lighter one, or near its joint.

The chain beyond a joint asks for the force A a + f, a the joint's acceleration minus gravity. With the joints' accelerations as
unknowns a link (mass m, beta = r / l, rate w, direction q, couple n of springs and dampers, p = n / l) is one weighted sum of
squares, m |(1 - beta) a + beta a'|^2, and one constraint, q.(a' - a) = -l w^2, whose multiplier is s. With

    b = beta^2 m,   kappa = beta (1 - beta) m,   W = (b I + A)^-1,   v = q + kappa W q,   alpha' = 1 / q.W q
    a' = s W q - W (kappa a + f - p),   s = alpha' (v.a + c'),   c' = q.W (f - p) - l w^2

it passes on A' = alpha' v v^T + G' with G' = (1 - beta)^2 m I - kappa^2 W, and f' = c' alpha' v + d' with d' = p - kappa W (f - p).
It turns by omega' = q x (a' - a) / l. Of two links s q x W q goes by itself where w^2, which s holds, may be much more than omega' (`turns_alone`).

Whatever pulls along the chain, however heavy, stays in alpha; G, d and the rest are of the order of the masses next to the
joint. With T = b I + G, Q = adj T, x = q x u for the A = alpha u u^T + G beyond,

    E = det(b I + A) = det T + alpha u.Q u,   D = q.adj(b I + A) q = q.Q q + alpha x.T x,   alpha' = E / D
    W q = (Q q + alpha u x T x) / E,   W = (Q - (alpha / E) Q u (Q u)^T) / det T,   W u = Q u / E,

sums of positive terms where they divide. What is not is Q and G': G' is exact to eps (1 - beta)^2 m, which the next link divides by
its own b. `amplification` bounds how far such errors come, from the scene's numbers alone; where the bound is large the sweep
of `spatial.articulated` serves, which has no subtractions at about three times the operations.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import prod

from phichain.ir.builder import ArrayRef, Builder, Expr, Index
from phichain.lowering.algebra.matrix import Matrix, applied, cofactors, combine, dyads, symmetric, triangle
from phichain.lowering.algebra.vector import Vector, add, cross, dot, load, named, scale, store, sub, zeros
from phichain.lowering.chain.light_carriers import carries_lightly
from phichain.lowering.chain.losses import push_on_cart
from phichain.lowering.chain.parameters import Parameters
from phichain.lowering.spatial.links import couples, directions
from phichain.lowering.spatial.rates import Rates
from phichain.lowering.spatial.units import MobilityScales, amplification, known_links, turns_alone
from phichain.scene import Scene

#: Largest `amplification` of rounding errors, in units of the rounding of the state, with which this form is taken.
LARGEST_AMPLIFICATION = 100
#: Largest factor by which joints near the masses amplify an acceleration on its way outwards.
LARGEST_LEVERAGE = 32
#: Largest ratio of the links' inertias b: their cubes stay within the range of single precision.
LARGEST_SPREAD = 10**6


def suits(scene: Scene) -> bool:
    """Whether the errors of this form are bounded by the scene's numbers, all of which must be known.

    It hands accelerations alone outwards.
    """
    links = known_links(scene)
    if scene.tip_masses or scene.inertia is not None or links is None or isinstance(scene.cart_mass, str):
        return False
    own = [mass * beta * beta for mass, beta in links]
    leverage = prod(max(1, abs(1 - beta) / beta) for _, beta in links)
    is_even = max(own) <= LARGEST_SPREAD * min(own) and leverage <= LARGEST_LEVERAGE
    return is_even and amplification(links, scene.cart_mass) <= LARGEST_AMPLIFICATION and not carries_lightly(scene)


def accelerations(
    builder: Builder, scene: Scene, parameters: Parameters, q: ArrayRef, rates: Rates, u: ArrayRef | None
) -> None:
    """Write x'' and the omega_k' through `rates`."""
    Sweep(builder, scene, parameters, q, rates).run(u)


@dataclass(frozen=True)
class Beyond:
    """The chain beyond a joint: its u, alpha and c; -mu W and W (f - p) of its first link; that of the tip alone has no G."""

    direction: Vector
    axial: Expr
    pull: Expr
    mobility: Matrix | None
    yielding: Vector

    def flat(self) -> list[Expr]:
        """All scalars in a fixed order, for a loop to carry."""
        assert self.mobility is not None
        return [*self.direction, self.axial, self.pull, *triangle(self.mobility), *self.yielding]

    @staticmethod
    def from_flat(values: list[Expr]) -> Beyond:
        """The inverse of `flat`."""
        return Beyond(tuple(values[:3]), values[3], values[4], symmetric(values[5:11]), tuple(values[11:]))


@dataclass(frozen=True)
class Pivot:
    """What the elimination of a link is made of: T, det T, Q u, x, 1 / E, alpha' and (p - d) / mu."""

    own: Matrix
    determinant: Expr
    seen: Vector
    across: Vector
    inverse: Expr
    axial: Expr
    push: Vector | None


class Sweep:
    """The inward elimination and the outward substitution; work arrays carry one to the other."""

    def __init__(
        self, builder: Builder, scene: Scene, parameters: Parameters, q: ArrayRef, rates: Rates
    ) -> None:
        self.builder, self.scene, self.parameters = builder, scene, parameters
        self.direction, self.rates = directions(scene, q), rates
        self.scales = MobilityScales(parameters)
        self.inverse_length = parameters.derived("inverse_length", lambda k: 1 / parameters.length[k])
        self.pair = self._pairs()
        inner = max(scene.links - 1, 1)
        self.tension_axis = builder.array("tension_axis", 3 * inner)
        self.stretch_axis = builder.array("stretch_axis", 3 * inner)
        self.axial, self.pull = builder.array("axial", inner), builder.array("pull", inner)
        self.mobility = builder.array("mobility", 6 * inner)
        self.yielding = builder.array("yielding", 3 * inner)
        self.swing_axis = builder.array("swing_axis", 3 * inner) if turns_alone(scene) else None

    def run(self, u: ArrayRef | None) -> None:
        """Both ways; writes x'' and the omega_k'."""
        scene, parameters, rates = self.scene, self.parameters, self.rates
        chain = self.inwards()
        x, y, fall = (-entry for entry in parameters.fall)
        if scene.has_cart:
            unit = parameters.units
            first, second = (push_on_cart(scene, parameters, u, rates.cart(), axis) for axis in (0, 1))
            x, y = self.close_on_cart(chain, (first, second))
            rates.write_cart((x * unit.length, y * unit.length))
        self.outwards((x, y, fall))

    def couples(self) -> ArrayRef | None:
        """n_k of springs, dampers and dry friction."""
        return couples(self.builder, self.scene, self.parameters, self.direction, self.rates.angular, self.rates.bend)

    def eliminated(self, chain: Beyond, k: Index, pivot: Pivot) -> None:
        """What else is kept of the elimination of a link but the last: nothing."""

    def moved(self, k: Index, joint: Vector, stretched: Expr | None) -> None:
        """What else is kept of a link's joint, and of v.a + c' but for the last link's: nothing."""

    def closed(self, firm: Vector, axial: Expr, lean: tuple[Expr, Expr], inverse: Expr) -> None:
        """What else is kept of a cart's inertia B + alpha h h^T, B as xx, xy, yy, and of 1 / its determinant: nothing."""

    def _pairs(self) -> ArrayRef | None:
        """p_k = n_k / l_k, what springs and dampers do to the link as a pair of forces at its ends."""
        couple = self.couples()
        if couple is None:
            return None
        pair = self.builder.array("force_pair", 3 * self.scene.links)
        with self.builder.loop("k", 0, self.scene.links) as loop:
            store(pair, loop.index, scale(self.inverse_length[loop.index], load(couple, loop.index)))
        return pair

    def inwards(self) -> Beyond:
        """The chain beyond the base."""
        links = self.scene.links
        chain = self._tip()
        if links == 1:
            return chain
        chain = self.eliminate(chain, links - 2)
        if links == 2:
            return chain
        with self.builder.loop("k", links - 3, -1, -1) as loop:
            carried = [loop.carry("beyond", value) for value in chain.flat()]
            following = self.eliminate(Beyond.from_flat(carried), loop.index)
            for before, after in zip(carried, following.flat(), strict=True):
                loop.follow(before, after)
        return Beyond.from_flat(carried)

    def _tip(self) -> Beyond:
        """The last link alone: A = m q q^T, f = -m r w^2 q + (l / r) p."""
        tip, builder, parameters = self.scene.links - 1, self.builder, self.parameters
        yielding = zeros(builder, 3)
        if self.pair is not None:
            yielding = scale(-(1 / self.scales.own[tip]), load(self.pair, tip))
        pull = -(parameters.com[tip] * self.rates.squared(tip))
        return Beyond(load(self.direction, tip), parameters.mass[tip], pull, None, yielding)

    def eliminate(self, chain: Beyond, k: Index) -> Beyond:
        """Link k and all beyond it."""
        let, scales = self.builder.let, self.scales
        q, u, alpha = load(self.direction, k), chain.direction, chain.axial
        own = self._own(chain, k)
        adjugate = cofactors(own)
        determinant = let("determinant", dot(own[0], adjugate[0]))
        seen, facing = named(self.builder, "seen", applied(adjugate, u)), applied(adjugate, q)
        across = named(self.builder, "across", cross(q, u))
        pressed = applied(own, across)
        whole = let("whole", determinant + alpha * dot(u, seen))
        inverse = let("inverse_whole", 1 / whole)
        axis = scale(inverse, add(facing, scale(alpha, cross(u, pressed))))
        axial = let("axial_here", whole / (dot(q, facing) + alpha * dot(across, pressed)))
        if self.swing_axis is not None:
            # beside a tip alone T is b I: of W q all but u x T x is along q
            store(self.swing_axis, k, scale(alpha * inverse, cross(q, cross(u, pressed))))
        drawn = scale(alpha * inverse, seen)
        mobility = combine((scales.scale[k] / determinant, symmetric(sub(triangle(dyads(drawn, seen)), triangle(adjugate)))))
        yielding = scale(chain.pull, drawn)
        push = self._push(chain, k)
        if push is not None:
            yielding = add(yielding, applied(mobility, push))
        self.eliminated(chain, k, Pivot(own, determinant, seen, across, inverse, axial, push))
        pull = let("pull_here", dot(q, yielding) - self.parameters.length[k] * self.rates.squared(k))
        stretch = add(q, scale(scales.lever[k], axis))
        self.axial[k], self.pull[k] = axial, pull
        vectors = (self.tension_axis, axis), (self.stretch_axis, stretch), (self.yielding, yielding)
        for array, value in vectors:
            store(array, k, value)
        store(self.mobility, k, triangle(mobility))
        return Beyond(stretch, axial, pull, mobility, yielding)

    def _own(self, chain: Beyond, k: Index) -> Matrix:
        """T = b I + G."""
        if chain.mobility is None:
            own, nothing = self.scales.own[k], self.builder.lift(0)
            return symmetric((own, nothing, nothing, own, nothing, own))
        pivot, slack = self.scales.pivot[k], self.scales.slack[k]
        xx, xy, xz, yy, yz, zz = (slack * entry for entry in triangle(chain.mobility))
        return symmetric((pivot + xx, xy, xz, pivot + yy, yz, pivot + zz))

    def _push(self, chain: Beyond, k: Index) -> Vector | None:
        """(p - d) / mu; None where nothing pushes but along u."""
        if chain.mobility is None and self.pair is None:
            return None
        pushed = scale(self.scales.push[k], chain.yielding)
        if self.pair is None:
            return pushed
        share = 1 / self.scales.scale[k]
        return add(pushed, scale(share, sub(load(self.pair, k), load(self.pair, k + 1))))

    def close_on_cart(self, chain: Beyond, force: tuple[Expr, Expr]) -> tuple[Expr, Expr]:
        """(m_c I + alpha u u^T + G) x'' = force - alpha (c - g u_z) u - d + g G e_3, all horizontal."""
        parameters, scales, alpha = self.parameters, self.scales, chain.axial
        cart, gravity, (x, y, z) = parameters.base_mass, parameters.gravity, chain.direction
        push = [scales.lever[0] * entry for entry in chain.yielding]
        if self.pair is not None:
            push = [entry - own for entry, own in zip(push, load(self.pair, 0), strict=True)]
        first, second = force[0] + push[0], force[1] + push[1]
        xx = yy = self.builder.lift(cart)
        xy = self.builder.lift(0)
        if chain.mobility is not None:
            slack, firm = scales.base_slack, cart + scales.base_overhang
            (xx, xy, xz), (_, yy, yz), _ = chain.mobility
            xx, xy, yy = firm + slack * xx, slack * xy, firm + slack * yy
            first, second = first + gravity * (slack * xz), second + gravity * (slack * yz)
        # adj(B + alpha h h^T) r = adj(B) r + alpha h* (h*.r), h* = (-y, x)
        along = alpha * (x * second - y * first)
        fall = alpha * (chain.pull - gravity * z)
        first, second = first - fall * x, second - fall * y
        heavy = x * (yy * x - xy * y) + y * (xx * y - xy * x)
        inverse = self.builder.let("inverse_cart_pivot", 1 / ((xx * yy - xy * xy) + alpha * heavy))
        self.closed((xx, xy, yy), alpha, (x, y), inverse)
        return (
            self.builder.let("cart_acceleration_0", ((yy * first - xy * second) - along * y) * inverse),
            self.builder.let("cart_acceleration_1", ((xx * second - xy * first) + along * x) * inverse),
        )

    def outwards(self, base: Vector) -> None:
        """omega_k' = q_k x (a' - a) / l_k, and on to the next joint."""
        tip = self.scene.links - 1
        if tip == 0:
            self._turn_tip(base)
            return
        with self.builder.loop("k", 0, tip) as loop:
            k = loop.index
            joint: Vector = tuple(loop.carry(f"joint_{x}", part) for x, part in zip("xyz", base, strict=True))
            stretched = dot(load(self.stretch_axis, k), joint) + self.pull[k]
            tension = self.builder.let("tension", self.axial[k] * stretched)
            self.moved(k, joint, stretched)
            first, second = load(self.mobility, 2 * k), load(self.mobility, 2 * k + 1)
            carried = scale(self.scales.lean[k], applied(symmetric((*first, *second)), joint))
            left = sub(carried, load(self.yielding, k))
            end = add(scale(tension, load(self.tension_axis, k)), left)
            turning = cross(load(self.direction, k), sub(end if self.swing_axis is None else left, joint))
            if self.swing_axis is not None:
                turning = add(scale(tension, load(self.swing_axis, k)), turning)
            self.rates.write(k, scale(self.inverse_length[k], turning))
            for before, after in zip(joint, end, strict=True):
                loop.follow(before, after)
        self._turn_tip(joint)

    def _turn_tip(self, joint: Vector) -> None:
        """The last link swings about its joint: omega' = q x (p / b - a / beta) / l."""
        tip, com = self.scene.links - 1, self.parameters.com
        self.moved(tip, joint, None)
        turning = scale(-(1 / com[tip]), joint)
        if self.pair is not None:
            share = self.inverse_length[tip] / self.scales.own[tip]
            turning = add(turning, scale(share, load(self.pair, tip)))
        self.rates.write(tip, cross(load(self.direction, tip), turning))
