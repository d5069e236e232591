"""Taylor recurrences of rigid spatial links that may be held at their centres of mass: `articulated_links`, order by order.

The sweep of `spatial.articulated` measures a link by its point mass, which lies nowhere where the first moment vanishes. This one
measures by moments about the joint. In the names of `lowering.steps.articulated_links`, with normal = q, A and b of what lies beyond
a joint, Y the known part of (mu q)_n and the couple, and sigma = q.q'' known from the squares, the coefficients of order n obey

    D q'' = Y - l b + mu q - (m r + l A) a,    q.q'' = sigma

with q and A those of the step's start, so that D^-1, W, y = D^-1 q, p = W q and f = q.y are held and an order is

    inwards:   z = D^-1 (Y - l b),   e = (sigma - q.z) / f,   b' = W Y - gamma D^-1 b + e p
    outwards:  mu = e + p.a / f,   q'' = z + mu y - W a,   the next a = a + l q''

and a cart's (m_c + A) x'' = push - b - A rise closes it.
"""

from __future__ import annotations

from phichain.ir.builder import Expr, Index
from phichain.lowering.algebra.matrix import Matrix, adjugate, applied, combined, symmetric, triangle
from phichain.lowering.algebra.unit_vectors import ambient_size
from phichain.lowering.algebra.vector import Vector, add, dot, load, scale, store, sub
from phichain.lowering.series.held import Layout
from phichain.lowering.series.series import Series
from phichain.lowering.series.spatial.made import spatial_series
from phichain.lowering.series.spatial.ordering import Ordering
from phichain.lowering.series.spatial.rows import Factoring, joint_runs
from phichain.lowering.steps.articulated_links import Inertia, Link
from phichain.lowering.steps.link_multipliers import Links
from phichain.mechanics import Model
from phichain.scene import Scene

#: What is held of each link.
_PER_LINK = {"direction": 3, "yielding": 6, "turn": 6, "eased": 6, "response": 3, "pull": 3, "seen": 3, "over": 1}


def rigid_series(model: Model) -> Series:
    """The recurrences of a spatial scene with rigid links."""
    return spatial_series(model, model.scene, _layout(model.scene), _factor, _order)


def _layout(scene: Scene) -> Layout:
    cart = scene.has_free_cart
    return Layout(
        [
            *((name, size * scene.links) for name, size in _PER_LINK.items()), ("base", 3), ("cart", 3 * cart), ("lifted", 2 * cart),
            ("push", 2 * (scene.is_driven or scene.has_force)), ("cart_damping", int(cart and scene.cart_damping is not None)),
            *joint_runs(scene),
        ]
    )  # fmt: skip


def _factor(step: Factoring) -> None:
    """The elimination from the tip to the base."""
    builder, scene, parameters = step.builder, step.scene, step.parameters
    q, along = builder.array("place", ambient_size(scene)), builder.array("still_along", scene.links)
    links = Links(builder, scene, parameters, q, q, along, None, None, q)
    with builder.loop("k", 0, scene.links) as loop:
        k = loop.index
        along[k] = builder.lift(0)
        links.write(k, load(step.direction, k))
        store(step.keep("direction"), k, load(step.direction, k))
    with builder.loop("k", scene.links - 1, -1, -1) as loop:
        k = loop.index
        inertia = Inertia.carried(loop, 3)
        nothing = builder.lift(0)
        link = Link(links, k, inertia, (nothing, nothing, nothing))
        for name, matrix in (("yielding", link.yielding), ("turn", link.turn), ("eased", combined(link.lever, link.yielding, 0))):
            store(step.keep(name), k, triangle(matrix))
        for name, vector in (("response", link.response), ("pull", link.pull), ("seen", link.seen), ("over", (link.over,))):
            store(step.keep(name), k, vector)
        for before, after in zip(inertia.entries, link.inertia_at_base.entries, strict=True):
            loop.follow(before, after)
    _factor_base(step, inertia.matrix)


def _factor_base(step: Factoring, inertia: Matrix) -> None:
    """Hold what is constant in time: the base's acceleration less gravity, a cart's push and what it must lift, and its pivot."""
    builder, scene, parameters = step.builder, step.scene, step.parameters
    rise = tuple(-entry * step.square for entry in parameters.fall)
    store(step.keep("base"), 0, rise)
    step.keep_driven()
    if not scene.has_free_cart:
        return
    horizontal = tuple(row[:-1] for row in inertia[:-1])
    pivot = combined(1, horizontal, parameters.base_mass)
    minors = adjugate(pivot)
    over = builder.let("over_cart", 1 / (pivot[0][0] * minors[0][0] + pivot[0][1] * minors[1][0]))
    store(step.keep("cart"), 0, tuple(over * entry for entry in (minors[0][0], minors[0][1], minors[1][1])))
    store(step.keep("lifted"), 0, applied(inertia, rise)[:-1])
    if step.u is not None and scene.has_force:
        store(step.keep("push"), 0, tuple(step.u[i] * step.square for i in range(2)))
    if parameters.cart_damping is not None:
        step.keep("cart_damping")[0] = step.rho * parameters.cart_damping
    step.keep_cart_friction(1)


def _order(order: Ordering) -> None:
    """Loads inwards, accelerations outwards."""
    _Order(order).run()


class _Order:
    """One order: z and e of every link on the way in, q'' and mu on the way out."""

    def __init__(self, order: Ordering) -> None:
        self.order, self.builder, self.links = order, order.builder, order.scene.links
        self.free, self.excess = self.builder.array("free", 3 * self.links), self.builder.array("excess", self.links)

    def vector(self, name: str, k: Index) -> Vector:
        return load(self.order.kept(name), k)

    def matrix(self, name: str, k: Index) -> Matrix:
        kept = self.order.kept(name)
        return symmetric((*load(kept, 2 * k), *load(kept, 2 * k + 1)))

    def run(self) -> None:
        """Write what the order finds."""
        bias = self.inner(self.links - 1, None)
        if self.links > 1:
            with self.builder.loop("k", self.links - 2, -1, -1) as loop:
                carried = tuple(loop.carry("bias_beyond", entry) for entry in bias)
                for before, after in zip(carried, self.inner(loop.index, carried), strict=True):
                    loop.follow(before, after)
            bias = carried
        joint: Vector = tuple(self.order.first * self.order.kept("base")[i] for i in range(3))
        if self.order.scene.has_free_cart:
            joint = (*self.cart(bias), joint[2])
        else:
            self.order.write_driven()
        with self.builder.loop("k", 0, self.links) as loop:
            here = tuple(loop.carry("joint", entry) for entry in joint)
            for before, after in zip(here, self.outer(loop.index, here), strict=True):
                loop.follow(before, after)

    def inner(self, k: Index, bias: Vector | None) -> Vector:
        """Link k: b' of b; beyond the tip there is nothing."""
        known = load(self.order.sums, k)
        if self.order.couple is not None:
            known = add(known, load(self.order.couple, k))
        pressed = known if bias is None else sub(known, scale(self.order.parameters.length[k], bias))
        free = applied(self.matrix("yielding", k), pressed)
        store(self.free, k, free)
        drawn = self.order.along(k) - dot(self.vector("direction", k), free)
        self.excess[k] = excess = self.builder.let("excess_k", drawn * self.order.kept("over")[k])
        passed = add(applied(self.matrix("turn", k), known), scale(excess, self.vector("pull", k)))
        return passed if bias is None else sub(passed, applied(self.matrix("eased", k), bias))

    def cart(self, bias: Vector) -> tuple[Expr, Expr]:
        """x''."""
        order, (xx, xy, yy) = self.order, (self.order.kept("cart")[i] for i in range(3))
        force = [-(bias[i] + order.first * order.kept("lifted")[i]) for i in range(2)]
        if order.scene.has_force:
            force = [entry + order.first * order.kept("push")[i] for i, entry in enumerate(force)]
        if "cart_damping" in order.layout:
            force = [entry - order.kept("cart_damping")[0] * order.cart_rate(i) for i, entry in enumerate(force)]
        if (dry := order.cart_friction()) is not None:
            force = [entry - rub for entry, rub in zip(force, dry, strict=False)]
        x, y = (self.builder.let("cart_push", entry) for entry in force)
        found = xx * x + xy * y, xy * x + yy * y
        order.write_cart(found)
        return found

    def outer(self, k: Index, joint: Vector) -> Vector:
        """Write link k under a joint; returns the next joint's acceleration."""
        multiplier = self.builder.let("multiplier", self.excess[k] + dot(self.vector("seen", k), joint))
        bent = add(load(self.free, k), scale(multiplier, self.vector("response", k)))
        bent = sub(bent, applied(self.matrix("turn", k), joint))
        self.order.write(k, bent, self.builder.lift(1), multiplier)
        return add(joint, scale(self.order.parameters.length[k], bent))
