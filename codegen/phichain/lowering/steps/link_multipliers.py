"""Accelerations of the unit vectors under constraints that need not be their own: what implicit steps solve, again and again.

    (M a)_k = force_k + lambda_k q_k,   normal_k . a_k = along_k,   M_00 x'' + sum mu_k C^T a_k = u

with M the constant inertia of theory section 1 on vectors, gravity put in. normal = q, along = -|q'|^2 are the equations of
motion (15); a step that has to end on the spheres asks for the direction it moves to, normal = q + h q'. The multipliers
lambda then solve a system without symmetry, in O(N) all the same.

Masses at the links' ends: a tridiagonal system for the tensions, as in section 5. With c_k = normal_k.q_k and
rho_k = m_k / m_{k-1} its pivots are c_k + t_k,

    t_k = rho_k ((normal_{k-1} ^ normal_k).(q_{k-1} ^ q_k) + c_k t_{k-1}) / (c_{k-1} + t_{k-1}),

since (a ^ b).(c ^ d) = (a.c)(b.d) - (a.d)(b.c): what would cancel is formed as a product. Other chains: `articulated_links`.
"""

from __future__ import annotations

from dataclasses import dataclass

from phichain.ir.builder import ArrayRef, Builder, Expr, Index
from phichain.lowering.algebra.unit_vectors import cart_size, dimension
from phichain.lowering.algebra.vector import (
    Vector,
    add,
    cross,
    dot,
    load,
    multiple,
    named,
    store,
    sub,
    zeros,
)
from phichain.lowering.chain.parameters import Parameters
from phichain.scene import Scene


@dataclass(frozen=True)
class Links:
    """The arguments of `accelerations`, vector by vector; arrays hold [x, q_1 .. q_N] and alike.

    Attributes:
        builder: where the Program is recorded.
        scene: the chain.
        parameters: its numbers.
        q: directions the multipliers act along.
        normal: directions that see the accelerations.
        along: what they see, N cells.
        couple: forces conjugate to the unit vectors, no cart cells; None without any.
        push: horizontal force on the cart, or None.
        out: accelerations.
        lead: what rotors at the joints are accelerated by beside what the vectors say, against the link before; None without rotors.
    """

    builder: Builder
    scene: Scene
    parameters: Parameters
    q: ArrayRef
    normal: ArrayRef
    along: ArrayRef
    couple: ArrayRef | None
    push: Vector | None
    out: ArrayRef
    lead: ArrayRef | None = None

    @property
    def size(self) -> int:
        """2 in the plane, 3 in space."""
        return dimension(self.scene)

    def at(self, array: ArrayRef, k: Index) -> Vector:
        """Link k's vector."""
        return load(array.shifted(cart_size(self.scene)), k, self.size)

    def write(self, k: Index, value: Vector) -> None:
        """Link k's acceleration."""
        store(self.out.shifted(cart_size(self.scene)), k, value)

    def force(self, k: Index) -> Vector:
        """Link k's couple as the force that it is at the link's end."""
        if self.couple is None:
            return zeros(self.builder, self.size)
        length = self.parameters.length
        over_length = self.parameters.derived("over_length", lambda k: 1 / length[k])
        return multiple(over_length[k], load(self.couple, k, self.size))


def tensions(links: Links) -> None:
    """Accelerations of a chain with every mass at its link's end."""
    builder, parameters = links.builder, links.parameters
    count, size = links.scene.links, links.size
    pair = _pairs(links)
    share, load_array = builder.array("over_pivot", count), builder.array("load", count)
    first = _base_row(links, pair, share, load_array)
    with builder.loop("k", 1, count) as loop:
        k = loop.index
        weight, past_load, past_share = (loop.carry(name, x) for name, x in zip(_CARRIED, first, strict=True))
        q, normal = links.at(links.q, k), links.at(links.normal, k)
        before, normal_before = links.at(links.q, k - 1), links.at(links.normal, k - 1)
        ratio = parameters.mass_ratio[k]
        overlap = builder.let("overlap", dot(normal, q))
        bend = dot(cross(normal_before, normal), cross(before, q))
        following = builder.let("weight", ratio * ((bend + overlap * weight) * past_share))
        own = -(parameters.mass[k] * parameters.length[k] * links.along[k])
        if pair is not None:
            own = own + dot(normal, _net(links, pair, k, ratio))
        passed = ratio * dot(normal, before) * (past_load * past_share)
        total = builder.let("row_load", own + passed)
        inverse = builder.let("pivot_share", 1 / (overlap + following))
        share[k], load_array[k] = inverse, total
        for carried, value in zip((weight, past_load, past_share), (following, total, inverse), strict=True):
            loop.follow(carried, value)
    tension = _substituted(links, share, load_array)
    _write_accelerations(links, _forces(links, tension, pair), size)


_CARRIED = ("weight_before", "load_before", "share_before")


def _pairs(links: Links) -> ArrayRef | None:
    """The couples as forces at the links' ends, zero beyond the tip; None without couples."""
    if links.couple is None:
        return None
    builder, count, size = links.builder, links.scene.links, links.size
    pair = builder.array("pair", size * (count + 1))
    with builder.loop("k", 0, count) as loop:
        store(pair, loop.index, links.force(loop.index))
    store(pair, count, zeros(builder, size))
    return pair


def _net(links: Links, pair: ArrayRef, k: Index, ratio: Expr) -> Vector:
    """m_k times what pairs alone would accelerate link k's end by, against its base: (1 + rho) f_k - f_{k+1} - rho f_{k-1}."""
    here, beyond, before = (load(pair, i, links.size) for i in (k, k + 1, k - 1))
    return sub(sub(multiple(1 + ratio, here), beyond), multiple(ratio, before))


def _base_row(
    links: Links, pair: ArrayRef | None, share: ArrayRef, load_array: ArrayRef
) -> tuple[Expr, Expr, Expr]:
    """Link 0 on its base: (t_0, its load, 1 / pivot)."""
    builder, parameters, size = links.builder, links.parameters, links.size
    q, normal = links.at(links.q, 0), links.at(links.normal, 0)
    mass = parameters.mass[0]
    fall = dot(parameters.fall, normal) - parameters.length[0] * links.along[0]
    total = mass * fall
    if pair is not None:
        total = total + dot(normal, sub(load(pair, 0, size), load(pair, 1, size)))
    weight = builder.lift(0)
    if links.scene.has_cart:
        ratio = builder.let("cart_ratio", mass / parameters.base_mass)
        weight = builder.let("cart_weight", ratio * dot(normal[:-1], q[:-1]))
        sideways = _sideways(links, zeros(builder, size - 1) if pair is None else load(pair, 0, size)[:-1])
        total = total + ratio * dot(normal[:-1], sideways)
    inverse = builder.let("first_share", 1 / (dot(normal, q) + weight))
    total = builder.let("first_load", total)
    share[0], load_array[0] = inverse, total
    return weight, total, inverse


def _sideways(links: Links, force: Vector) -> Vector:
    """Minus the horizontal force on the cart, when its first link pulls with `force`."""
    return force if links.push is None else sub(force, links.push)


def _substituted(links: Links, share: ArrayRef, load_array: ArrayRef) -> ArrayRef:
    builder, tip = links.builder, links.scene.links - 1
    tension = builder.array("tension", tip + 1)
    last = builder.let("tip_tension", load_array[tip] * share[tip])
    tension[tip] = last
    with builder.loop("k", tip - 1, -1, -1) as loop:
        k = loop.index
        beyond = loop.carry("tension_beyond", last)
        pulled = dot(links.at(links.normal, k), links.at(links.q, k + 1)) * beyond
        value = builder.let("link_tension", (load_array[k] + pulled) * share[k])
        tension[k] = value
        loop.follow(beyond, value)
    return tension


def _forces(links: Links, tension: ArrayRef, pair: ArrayRef | None) -> ArrayRef:
    """Force of every link on the mass at its end, zero beyond the tip."""
    builder, count, size = links.builder, links.scene.links, links.size
    force = builder.array("link_force", size * (count + 1))
    with builder.loop("k", 0, count) as loop:
        k = loop.index
        pull = multiple(-tension[k], links.at(links.q, k))
        store(force, k, pull if pair is None else add(pull, load(pair, k, size)))
    store(force, count, zeros(builder, size))
    return force


def _write_accelerations(links: Links, force: ArrayRef, size: int) -> None:
    """l_k a_k is what the forces accelerate the mass at link k's end by, less that at its base."""
    builder, parameters = links.builder, links.parameters
    fall = parameters.fall
    here = load(force, 0, size)
    against = add(fall, multiple(1 / parameters.mass[0], sub(here, load(force, 1, size))))
    if links.scene.has_cart:
        cart = multiple(-1 / parameters.base_mass, _sideways(links, here[:-1]))
        cart = named(builder, "cart", cart)
        for i, entry in enumerate(cart):
            links.out[i] = entry
        against = (*sub(against[:-1], cart), against[-1])
    links.write(0, multiple(1 / parameters.length[0], against))
    with builder.loop("k", 1, links.scene.links) as loop:
        k = loop.index
        net = _net(links, force, k, parameters.mass_ratio[k])
        over = parameters.derived("over_moment", lambda k: 1 / (parameters.mass[k] * parameters.length[k]))
        links.write(k, multiple(over[k], net))
