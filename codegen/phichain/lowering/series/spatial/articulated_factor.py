"""The factorisation of `articulated`: the sweep of `spatial.articulated` under unit loads, in closed forms free of cancellation.

A load is the chain's bias force beyond a joint, f = c alpha u + d; pull c = 1, or d one axis of space as far as it is across the
chain's first link. What a link makes of each is a column of its matrices.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from typing import Final

from phichain.ir.builder import Builder, Expr, Index
from phichain.lowering.algebra.matrix import Matrix, applied, combine, dyads, triangle
from phichain.lowering.algebra.vector import Vector, add, cross, dot, load, scale, store, sub
from phichain.lowering.chain.body import is_folded
from phichain.lowering.chain.losses import ties_links
from phichain.lowering.series.held import Layout
from phichain.lowering.series.spatial.rows import Factoring, joint_runs
from phichain.lowering.spatial.outer import Outer, Seen
from phichain.lowering.spatial.units import SpatialUnits
from phichain.scene import Scene

_STEEP: Final = 30
"""Where a mass is so many times that before it, loads are kept apart as the sweep of a single time has them."""


def load_size(scene: Scene) -> int:
    """Numbers of a load beside its pull: d, and on chains that grow heavy outwards adj(G) d, which d alone gives with lost digits."""
    if isinstance(scene.mass, str) or scene.inertia is not None:
        return 3
    return 6 if any(outer > _STEEP * inner for inner, outer in pairwise(scene.mass)) else 3


def _per_link(scene: Scene) -> dict[str, int]:
    """What is held of each link."""
    size = load_size(scene)
    return {
        "direction": 3, "turned": 3, "reply": 6,  # q, s, R
        "passed": 6, "push_pull": size, "push_push": size * size, "push_along": size,  # T, h, H, j
        "pull_pull": 1, "pull_push": size, "pull_known": 3, "pull_along": 1, "ease_along": 1,  # c' of c, d, Y and sigma; g of -sigma
        "lean": 3, "free_pull": 3,  # nu', R alpha u
        "stretch_axial": 1, "stretch_pull": 1, "stretch_push": size, "stretch_known": 3,  # y^+ of z, c, d and Y
        "force_axial": 1, "force_stretch": 1, "force_joint": 3,  # beta alpha', (1 - beta) alpha q.u, (1 - beta) G q
        **({"passed_minor": 9, "free_push": 18} if size > 3 else {}),  # adj(G') d' of Y, R d
    }  # fmt: skip


_UNITS: Final = ("overhang", "lever", "length", "outward")
"""Numbers of the links that are held where they are no constants."""


def layout(scene: Scene) -> Layout:
    links, cart = scene.links, scene.has_free_cart
    held_units = links * (not is_folded(scene))
    couples = ties_links(scene)
    return Layout(
        [
            *((name, size * links) for name, size in _per_link(scene).items()), ("base", 3 + cart), ("cart", 3 * (1 + load_size(scene)) * cart),
            ("push", 2 * scene.is_driven), *joint_runs(scene),
            ("cart_damping", 6 * (cart and scene.cart_damping is not None)), ("cart_rubbed", 6 * (cart and scene.cart_friction is not None)),
            *((f"unit_{name}", held_units) for name in _UNITS), ("unit_inverse_torque", held_units * couples),
        ]
    )  # fmt: skip


def factor(step: Factoring) -> None:
    """The elimination from the tip to the base, with unit loads in the place of what the orders bring."""
    builder, scene = step.builder, step.scene
    units = SpatialUnits(builder, scene, step.parameters)
    for name in (*_UNITS, "inverse_torque"):
        if f"unit_{name}" in step.layout:
            with builder.loop("k", 0, scene.links) as loop:
                step.keep(f"unit_{name}")[loop.index] = getattr(units, name)[loop.index]
    links, last = scene.links, 0 if scene.has_free_cart else 1
    chain = Outer.from_flat([builder.lift(0)] * 21)
    chain = _eliminate(step, units, chain, links - 1)
    if links - 1 > last:
        with builder.loop("k", links - 2, last - 1, -1) as loop:
            carried = [loop.carry("outer", value) for value in _geometry(chain)]
            for before, after in zip(carried, _geometry(_eliminate(step, units, _chain(builder, carried), loop.index)), strict=True):
                loop.follow(before, after)
        chain = _chain(builder, carried)
    if scene.has_free_cart:
        _close_on_cart(step, units, chain)
        return
    if links > 1:
        _eliminate(step, units, chain, 0)
    step.keep_driven()
    for i in (2, 0, 1):
        step.keep("base")[i] = -(step.parameters.fall[i] * step.square) / step.parameters.length[0]


def _geometry(chain: Outer) -> list[Expr]:
    """What a loop carries: all but the loads."""
    return chain.flat()[:14]


def _chain(builder: Builder, geometry: list[Expr]) -> Outer:
    return Outer.from_flat([*geometry, *[builder.lift(0)] * 7])


def _loaded(chain: Outer, size: int) -> list[Outer]:
    """The chain under unit loads: pull, push along each axis as far as it is across the first link, and where loads have six
    numbers each axis of adj(G) d, then no part of the push.
    """
    builder, o = chain.axial.builder, chain.direction
    one, nothing = builder.lift(1), builder.lift(0)
    loads = [replace(chain, pull=one)]
    axes = [tuple(one if j == i else nothing for j in range(3)) for i in range(3)]
    across = [sub(axis, scale(o[i], o)) for i, axis in enumerate(axes)]
    if size > 3:
        loads += [replace(chain, push=push) for push in across]
        return loads + [replace(chain, minor=minor) for minor in across]
    minors = [cross(o, applied(chain.tangent, cross(axis, o))) for axis in axes]
    return loads + [replace(chain, push=push, minor=minor) for push, minor in zip(across, minors, strict=True)]


def _eliminate(step: Factoring, units: SpatialUnits, chain: Outer, k: Index) -> Outer:
    """Hold the matrices of link k; the chain from its base joint on, in the units of the link before."""
    let, q = step.builder.let, load(step.direction, k)
    own, overhang, lever = units.reach_squared[k], units.overhang[k], units.lever[k]
    size = load_size(step.scene)
    seen, (pulled, *pushed) = Seen(chain, q, own), [Seen(loaded, q, own) for loaded in _loaded(chain, size)]
    inverse = let("inverse_pivot", 1 / (own * (own + seen.trace) + seen.adjugate_axial))
    s = sub(scale(own * inverse, seen.mixed), scale(inverse, seen.adjugate_mixed))
    bare = combine(
        (seen.across_trace, seen.projector),
        (1, dyads(scale(seen.outer.axial, seen.x), seen.x)), (-1, seen.tangent),
    )  # fmt: skip
    reply = combine((inverse, bare))
    added = let("axial", (own * (own * seen.axial + seen.adjugate_trace) + seen.determinant) * inverse)
    over = let("inverse_axial", 1 / (1 + added))
    mass, length = units.mass[k], units.length[k]
    unit, leaning = mass * length, lever * over

    def freed(loaded: Seen) -> Vector:
        """R f"""
        return add(scale(own * inverse, loaded.force), scale(inverse, loaded.turned_force))

    def held_back(loaded: Seen) -> Vector:
        """alpha' (R f - s (w.f) / alpha')"""
        return add(freed(loaded), scale(inverse, loaded.crossed))

    keep = _Keep(step, k)
    keep.vector("direction", q)
    keep.vector("turned", s)
    keep.matrix("reply", reply)
    keep.matrix("passed", combine((unit, seen.projector), (unit * lever, reply), (unit * leaning, dyads(s, s))))
    passed, planar = mass * (units.overhang_squared[k] * (inverse * over)), seen.adjugate_axial + seen.determinant

    def passed_on(loaded: Seen) -> Vector:
        """-d', and -adj(G') d'"""
        minor = scale(unit * passed * lever, add(loaded.turned_force, loaded.adjugate_force)) if size > 3 else ()
        return *scale(unit * leaning, held_back(loaded)), *minor

    keep.vector("push_pull", passed_on(pulled))
    for i, loaded in enumerate(pushed):
        keep.column("push_push", i, size, passed_on(loaded))
    leant = scale(unit * passed * (lever * overhang), seen.adjugate_mixed) if size > 3 else ()
    keep.vector("push_along", (*scale(unit * (leaning * overhang), s), *(-entry for entry in leant)))
    if size > 3:
        for i, axis in enumerate(seen.projector):
            driven = scale(units.reach[k], add(seen.turned(axis), seen.adjugate(axis)))
            keep.column("passed_minor", i, 3, scale(unit * passed, add(driven, scale(planar, axis))))
        for i, loaded in enumerate(pushed):
            keep.column("free_push", i, size, freed(loaded))
    keep.number("pull_pull", over * (added * seen.along_o + own * dot(s, chain.direction)))
    keep.vector("pull_push", tuple(over * (loaded.axial_push * inverse) for loaded in pushed))
    keep.vector("pull_known", scale(over, s))
    keep.number("pull_along", over * (units.reach[k] + added))
    keep.number("ease_along", over * overhang)
    lean = scale(-leaning, s)
    keep.vector("lean", lean)
    keep.vector("free_pull", freed(pulled))
    keep.number("stretch_axial", inverse * seen.share)
    keep.number("stretch_pull", inverse * pulled.free_u)
    keep.vector("stretch_push", tuple(inverse * loaded.free_u for loaded in pushed))
    keep.vector("stretch_known", scale(inverse, seen.yielding_u))
    keep.number("force_axial", units.reach[k] * (1 + added))
    keep.number("force_stretch", overhang * (chain.axial * seen.along_u))
    keep.vector("force_joint", scale(overhang, seen.tangent_q))
    nothing = step.builder.lift(0)
    none: Vector = (nothing, nothing, nothing)
    return Outer(
        direction=q, axial=mass * (1 + added), lean=lean,
        tangent=combine((passed * own, _tangent(seen)), (passed * planar, seen.projector)),
        area=mass * units.overhang_squared[k] * (passed * planar), pull=nothing, push=none, minor=none,
    )  # fmt: skip


class _Keep:
    """Stores what is held of one link."""

    def __init__(self, step: Factoring, k: Index) -> None:
        self.step, self.k = step, k

    def number(self, name: str, value: Expr) -> None:
        self.step.keep(name)[self.k] = value

    def vector(self, name: str, value: Vector) -> None:
        store(self.step.keep(name), self.k, value)

    def column(self, name: str, i: int, width: int, value: Vector) -> None:
        """One column of a matrix that is held row by row."""
        for j, entry in enumerate(value):
            self.step.keep(name)[width * len(value) * self.k + width * j + i] = entry

    def matrix(self, name: str, value: Matrix) -> None:
        """A symmetric one."""
        store(self.step.keep(name), self.k, triangle(value))


def _tangent(seen: Seen) -> Matrix:
    """Gamma + turned(K), as in `spatial.articulated`."""
    axial = seen.outer.axial
    pressed = scale(axial * seen.along_u, seen.pressed)
    heavy = sub(scale(axial * (1 + seen.tangent_qq), seen.tangent_u), pressed)
    straight = dyads(seen.tangent_u, heavy, scale(-1, pressed), seen.tangent_u)
    flat = dyads(scale(seen.outer.area, seen.across_o), seen.across_o)
    return combine((1, straight), (1 + axial * (seen.along_u * seen.along_u), seen.tangent), (1, flat))


def _close_on_cart(step: Factoring, units: SpatialUnits, chain: Outer) -> None:
    """Hold x'', the first joint's acceleration and y there, of what is constant in time and of the chain's loads: a link of
    direction e_3 whose own inertia is the cart's.
    """
    builder, parameters, nothing = step.builder, step.parameters, step.builder.lift(0)
    down: Vector = (nothing, nothing, builder.lift(1))
    mass, length = units.mass_unit[0], parameters.length[0]
    cart, gravity = parameters.base_mass / mass, parameters.gravity * step.square / length
    seen = Seen(chain, down, cart)
    inverse = builder.let("inverse_cart_pivot", 1 / (cart * (cart + seen.trace) + seen.adjugate_axial))
    given: Vector = (nothing, nothing, nothing)
    if step.u is not None and step.scene.has_force:
        unit = step.square / (mass * length * parameters.units.force)
        given = (step.u[0] * unit, step.u[1] * unit, nothing)
    push = add(given, scale(gravity, seen.mixed))
    turned = sub(seen.turned(given), scale(gravity, seen.adjugate_mixed))
    x, y, _ = scale(inverse, add(scale(cart, push), turned))
    for i, entry in enumerate((x, y, -gravity)):
        step.keep("base")[i] = entry
    step.keep("base")[3] = inverse * (dot(seen.yielding_u, given) - gravity * seen.share)

    def answered(name: str, drag: Expr) -> None:
        """What x'' and the stretch make of forces on the cart."""
        for axis in range(2):
            resisted: Vector = tuple(drag if i == axis else nothing for i in range(3))
            answer = scale(inverse, add(scale(cart, resisted), seen.turned(resisted)))
            for row, entry in enumerate((answer[0], answer[1], inverse * dot(seen.yielding_u, resisted))):
                step.keep(name)[2 * row + axis] = entry

    if parameters.cart_damping is not None:
        answered("cart_damping", step.rho * (parameters.cart_damping / (mass * length * parameters.units.length)))
    if parameters.cart_friction is not None:
        answered("cart_rubbed", builder.lift(1))
        step.keep_cart_friction(mass * length)
    size = load_size(step.scene)
    for i, unit_load in enumerate(_loaded(chain, size)):
        loaded = Seen(unit_load, down, cart)
        x, y, _ = scale(-inverse, add(scale(cart, loaded.force), loaded.turned_force))
        for row, entry in enumerate((x, y, inverse * loaded.free_u)):
            step.keep("cart")[(1 + size) * row + i] = entry
