"""Taylor recurrences of spatial chains with masses anywhere: the articulated sweep of every order by constant matrices.

In units m and l of each link, with Y the known part of the link's multiplier (mu q)_n and its couple, sigma = q.q'' known from
the squares, a the acceleration of its joint less gravity and A a^+ + f the force at its tip, the coefficients of order n obey

    beta (a + beta q'') + A a^+ + f = mu q + Y,    a^+ = a + q''

with q and A those of the step's start. That is the sweep of `spatial.articulated` with sigma for -w^2 and Y for the couple: its
closed forms, free of cancellation, give the matrices once, here by what they answer to unit loads. With A = alpha u u^T + G,
f = c alpha u + d, R, s = R P A q, w = q - s, X, alpha' = 1 + X, nu' and D as there,

    g = (w.f + s.Y - (1 - beta) sigma) / alpha',   c' = g + sigma = (w.f + s.Y + (beta + X) sigma) / alpha'
    d' = P Y + beta (1 - beta) (R (Y - f) + s g)                                       = T Y - h c - H d - j sigma
    z = y - nu'.a - g (link 0: q.a + sigma),   P a^+ = R (Y - beta (1 - beta) a - f) - s z,   q.a^+ = z
    y^+ = u.a^+ + c,   q'' = P a^+ - P a + sigma q

The force at a joint along its link is alpha' y, never the sum of what makes it up, and mu + q.Y what both joints' forces make:

    mu = beta alpha' y + (1 - beta) (alpha (q.u) y^+ + q.(G a^+ + d)) - q.Y
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from phichain.ir.builder import ArrayRef, Builder, Expr, Index
from phichain.lowering.algebra.matrix import Matrix, applied, combine, dyads, symmetric, triangle
from phichain.lowering.algebra.vector import Vector, add, cross, dot, load, scale, store, sub
from phichain.lowering.series.held import Layout
from phichain.lowering.series.series import Series
from phichain.lowering.series.spatial_rows import (
    Factoring,
    Ordering,
    columns_program,
    factor_program,
    joint_runs,
    order_program,
    right_rows,
)
from phichain.lowering.spatial.outer import Outer, Seen
from phichain.lowering.spatial.units import SpatialUnits
from phichain.mechanics import Model
from phichain.scene import Scene

_PER_LINK = {
    "direction": 3, "turned": 3, "reply": 6,  # q, s, R
    "passed": 6, "push_pull": 3, "push_push": 9, "push_along": 3,  # T, h, H, j
    "pull_pull": 1, "pull_push": 3, "pull_known": 3, "pull_along": 1, "ease_along": 1,  # c' of c, d, Y and sigma; g of -sigma
    "lean": 3, "free_pull": 3,  # nu', R alpha u
    "stretch_axial": 1, "stretch_pull": 1, "stretch_push": 3, "stretch_known": 3,  # y^+ of z, c, d and Y
    "force_axial": 1, "force_stretch": 1, "force_joint": 3,  # beta alpha', (1 - beta) alpha q.u, (1 - beta) G q
}  # fmt: skip
"""What is held of each link."""

_UNITS = ("overhang", "lever", "length", "outward")
"""Numbers of the links that are held where they are no constants."""


def articulated_series(model: Model) -> Series:
    """The recurrences of a spatial scene with masses anywhere on their links."""
    scene = model.scene
    layout = _layout(scene)
    return Series(
        factor=factor_program(model, layout, _factor),
        order=order_program(model, layout, _order),
        columns=columns_program(scene) if scene.variational else None,
        lanes=3 * scene.links,
        rights=right_rows(scene),
        squares=3 * scene.links,
        held=layout.size,
    )


def _layout(scene: Scene) -> Layout:
    links, cart = scene.links, scene.has_cart
    held_units = links * bool({"mass", "length", "com"} & set(scene.runtime))
    couples = scene.stiffness is not None or scene.damping is not None
    return Layout(
        [
            *((name, size * links) for name, size in _PER_LINK.items()), ("base", 3 + cart), ("cart", 12 * cart), *joint_runs(scene),
            *((f"unit_{name}", held_units) for name in _UNITS), ("unit_inverse_torque", held_units * couples),
        ]
    )  # fmt: skip


# --- the factorisation ------------------------------------------------------------------------------------------------


def _factor(step: Factoring) -> None:
    """The elimination from the tip to the base, with unit loads in the place of what the orders bring."""
    builder, scene = step.builder, step.scene
    units = SpatialUnits(builder, scene, step.parameters)
    for name in (*_UNITS, "inverse_torque"):
        if f"unit_{name}" in step.layout:
            with builder.loop("k", 0, scene.links) as loop:
                step.keep(f"unit_{name}")[loop.index] = getattr(units, name)[loop.index]
    links, last = scene.links, 0 if scene.has_cart else 1
    chain = Outer.from_flat([builder.lift(0)] * 21)
    chain = _eliminate(step, units, chain, links - 1)
    if links - 1 > last:
        with builder.loop("k", links - 2, last - 1, -1) as loop:
            carried = [loop.carry("outer", value) for value in _geometry(chain)]
            for before, after in zip(carried, _geometry(_eliminate(step, units, _chain(builder, carried), loop.index)), strict=True):
                loop.follow(before, after)
        chain = _chain(builder, carried)
    if scene.has_cart:
        _close_on_cart(step, units, chain)
        return
    if links > 1:
        _eliminate(step, units, chain, 0)
    step.keep("base")[2] = -(step.parameters.gravity * step.square) / step.parameters.length[0]
    step.keep("base")[0] = step.keep("base")[1] = builder.lift(0)


def _geometry(chain: Outer) -> list[Expr]:
    """What a loop carries: all but the loads."""
    return chain.flat()[:14]


def _chain(builder: Builder, geometry: list[Expr]) -> Outer:
    return Outer.from_flat([*geometry, *[builder.lift(0)] * 7])


def _loaded(chain: Outer, i: int | None) -> Outer:
    """The chain under a unit load: of pull, or of push along one axis, across the first link as push is."""
    builder = chain.axial.builder
    one, nothing = builder.lift(1), builder.lift(0)
    if i is None:
        return replace(chain, pull=one)
    axis = tuple(one if j == i else nothing for j in range(3))
    o = chain.direction
    push = sub(axis, scale(o[i], o))
    minor = cross(o, applied(chain.tangent, cross(axis, o)))
    return replace(chain, push=push, minor=minor)


def _eliminate(step: Factoring, units: SpatialUnits, chain: Outer, k: Index) -> Outer:
    """Hold the matrices of link k; the chain from its base joint on, in the units of the link before."""
    let, q = step.builder.let, load(step.direction, k)
    own, overhang, lever = units.reach_squared[k], units.overhang[k], units.lever[k]
    seen, pulled = Seen(chain, q, own), Seen(_loaded(chain, None), q, own)
    pushed = [Seen(_loaded(chain, i), q, own) for i in range(3)]
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
    keep.vector("push_pull", scale(unit * leaning, held_back(pulled)))
    for i, loaded in enumerate(pushed):
        for j, entry in enumerate(scale(unit * leaning, held_back(loaded))):
            step.keep("push_push")[9 * k + 3 * j + i] = entry
    keep.vector("push_along", scale(unit * (leaning * overhang), s))
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
    passed, planar = mass * (units.overhang_squared[k] * (inverse * over)), seen.adjugate_axial + seen.determinant
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
    cart, gravity = parameters.cart_mass / mass, parameters.gravity * step.square / length
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
    for i in range(4):
        loaded = Seen(_loaded(chain, None if i == 0 else i - 1), down, cart)
        x, y, _ = scale(-inverse, add(scale(cart, loaded.force), loaded.turned_force))
        for row, entry in enumerate((x, y, inverse * loaded.free_u)):
            step.keep("cart")[4 * row + i] = entry


# --- one order --------------------------------------------------------------------------------------------------------


def _order(order: Ordering) -> None:
    """Loads inwards, accelerations outwards."""
    sweep = _Order(order)
    pull, push = sweep.inwards()
    base = [order.first * order.kept("base")[i] for i in range(3)]
    if not order.scene.has_cart:
        sweep.outwards((base[0], base[1], base[2]), None)
        return
    entries, loads, length = order.kept("cart"), (pull, *push), order.parameters.length[0]
    made = [base[0], base[1], order.first * order.kept("base")[3]]
    for row in range(3):
        for i, entry in enumerate(loads):
            made[row] = made[row] + entries[4 * row + i] * entry
        made[row] = order.builder.let(("base_x", "base_y", "base_stretch")[row], made[row])
    order.write_cart((made[0] * length, made[1] * length))
    sweep.outwards((made[0], made[1], base[2]), made[2])


class _Order:
    """The arrays of one order: c, d and g of every link's outer chain."""

    def __init__(self, order: Ordering) -> None:
        self.order, self.builder, self.links = order, order.builder, order.scene.links
        self.pull, self.push = self.builder.array("pull", self.links), self.builder.array("push", 3 * self.links)
        self.eased, self.drawn = self.builder.array("eased", self.links), self.builder.array("drawn", self.links)
        self.known = self._known()
        units = SpatialUnits(self.builder, order.scene, order.parameters)
        self.unit: Callable[[str], ArrayRef] = lambda name: (
            order.kept(f"unit_{name}") if f"unit_{name}" in order.layout else getattr(units, name)
        )

    def _known(self) -> ArrayRef:
        """Y_k: the sums and the couples."""
        order = self.order
        if order.couple is None:
            return order.sums
        unit = (
            order.kept("unit_inverse_torque") if "unit_inverse_torque" in order.layout
            else SpatialUnits(self.builder, order.scene, order.parameters).inverse_torque
        )  # fmt: skip
        known = self.builder.array("known", 3 * self.links)
        with self.builder.loop("k", 0, self.links) as loop:
            k = loop.index
            store(known, k, add(load(order.sums, k), scale(unit[k], load(order.couple, k))))
        return known

    def number(self, name: str, k: Index) -> Expr:
        return self.order.kept(name)[k]

    def vector(self, name: str, k: Index) -> Vector:
        return load(self.order.kept(name), k)

    def matrix(self, name: str, k: Index) -> Matrix:
        return symmetric((*load(self.order.kept(name), 2 * k), *load(self.order.kept(name), 2 * k + 1)))

    def inwards(self) -> tuple[Expr, Vector]:
        """c and d of the chain that the base carries."""
        nothing = self.builder.lift(0)
        pull, push = self.pass_on(self.links - 1, nothing, None)
        if self.links > 1:
            with self.builder.loop("k", self.links - 2, -1, -1) as loop:
                carried = loop.carry("pull_beyond", pull), *(loop.carry("push_beyond", entry) for entry in push)
                pull, push = self.pass_on(loop.index, carried[0], carried[1:])
                for before, after in zip(carried, (pull, *push), strict=True):
                    loop.follow(before, after)
            pull, push = carried[0], carried[1:]
        return pull, push

    def pass_on(self, k: Index, pull: Expr, push: Vector | None) -> tuple[Expr, Vector]:
        """Link k: (c, d) beyond it to (c', d') beyond its base joint; beyond the tip there is nothing."""
        along, known, nothing = self.order.along(k), load(self.known, k), self.builder.lift(0)
        drawn = dot(self.vector("pull_known", k), known)
        pressed = sub(applied(self.matrix("passed", k), known), scale(along, self.vector("push_along", k)))
        self.pull[k] = pull
        store(self.push, k, (nothing, nothing, nothing) if push is None else push)
        if push is not None:
            drawn = drawn + dot(self.vector("pull_push", k), push) + self.number("pull_pull", k) * pull
            rows = (load(self.order.kept("push_push"), 3 * k + i) for i in range(3))
            pressed = sub(pressed, add(tuple(dot(row, push) for row in rows), scale(pull, self.vector("push_pull", k))))
        drawn = self.builder.let("drawn_k", drawn)
        self.eased[k] = drawn - self.number("ease_along", k) * along
        self.drawn[k] = drawn = self.builder.let("pull_k", drawn + self.number("pull_along", k) * along)
        return self.unit("length")[k] * drawn, pressed

    def outwards(self, base: Vector, stretch: Expr | None) -> None:
        """q'' and mu of every link, from the base's acceleration and, where it moves, its stretch."""
        last, leaning = self.links - 1, dot(self.vector("lean", 0), base)
        if stretch is None:
            fall = self.builder.let("first_fall", dot(self.vector("direction", 0), base))
            axial = self.builder.let("first_axial", fall + self.order.along(0))
            stretch = self.builder.let("first_stretch", (fall + leaning) + self.drawn[0])
        else:
            axial = self.builder.let("first_axial", stretch - leaning - self.eased[0])
        joint, stretch = self.link(0, base, stretch, axial)
        if last > 1:
            with self.builder.loop("k", 1, last) as loop:
                carried = (*(loop.carry("joint", entry) for entry in joint), loop.carry("stretch", stretch))
                joint, stretch = self.inner(loop.index, carried[:3], carried[3])
                for before, after in zip(carried, (*joint, stretch), strict=True):
                    loop.follow(before, after)
            joint, stretch = carried[:3], carried[3]
        if last:
            self.inner(last, joint, stretch)

    def inner(self, k: Index, joint: Vector, stretch: Expr) -> tuple[Vector, Expr]:
        """A link beyond another: its joint's acceleration and stretch in its own units."""
        outward = self.unit("outward")[k]
        joint, stretch = scale(outward, joint), outward * stretch
        axial = stretch - dot(self.vector("lean", k), joint) - self.eased[k]
        return self.link(k, joint, stretch, self.builder.let("axial_k", axial))

    def link(self, k: Index, joint: Vector, stretch: Expr, axial: Expr) -> tuple[Vector, Expr]:
        """Write link k; the acceleration and the stretch of the joint at its tip, which a last link has none of."""
        order, is_tip = self.order, k == self.links - 1
        q, known, along = self.vector("direction", k), load(self.known, k), order.along(k)
        pressed = sub(known, scale(self.unit("lever")[k], joint))
        push, pull = load(self.push, k), self.pull[k]
        across = applied(self.matrix("reply", k), pressed if is_tip else sub(pressed, push))
        if not is_tip:
            across = sub(sub(across, scale(pull, self.vector("free_pull", k))), scale(axial, self.vector("turned", k)))
        multiplier = self.number("force_axial", k) * stretch - dot(q, known)
        bent = add(sub(across, joint), scale(dot(q, joint) + along, q))
        tip, beyond = joint, axial
        if not is_tip:
            tip = add(across, scale(axial, q))
            beyond = self.number("stretch_axial", k) * axial + dot(self.vector("stretch_known", k), pressed)
            beyond = beyond + (self.number("stretch_pull", k) * pull + dot(self.vector("stretch_push", k), push))
            beyond = self.builder.let("stretch_next", beyond)
            multiplier = multiplier + self.unit("overhang")[k] * dot(q, push)
            multiplier = multiplier + dot(self.vector("force_joint", k), tip) + self.number("force_stretch", k) * beyond
        order.write(k, bent, self.builder.lift(1), multiplier)
        return tip, beyond
