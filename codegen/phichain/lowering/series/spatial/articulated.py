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

from phichain.ir.builder import ArrayRef, Expr, Index
from phichain.lowering.algebra.matrix import Matrix, applied, symmetric
from phichain.lowering.algebra.vector import Vector, add, dot, load, scale, store, sub
from phichain.lowering.chain.body import point_masses
from phichain.lowering.series.series import Series
from phichain.lowering.series.spatial.articulated_factor import factor, layout, load_size
from phichain.lowering.series.spatial.made import spatial_series
from phichain.lowering.series.spatial.ordering import Ordering
from phichain.lowering.spatial.units import SpatialUnits
from phichain.mechanics import Model


def articulated_series(model: Model) -> Series:
    """The recurrences of a spatial scene with masses anywhere on their links."""
    scene = point_masses(model.scene)
    return spatial_series(model, scene, layout(scene), factor, _order)


def _order(order: Ordering) -> None:
    """Loads inwards, accelerations outwards."""
    sweep = _Order(order)
    pull, push = sweep.inwards()
    base = [order.first * order.kept("base")[i] for i in range(3)]
    if not order.scene.has_free_cart:
        order.write_driven()
        sweep.outwards((base[0], base[1], base[2]), None)
        return
    entries, loads, length = order.kept("cart"), (pull, *push), order.parameters.length[0]
    made = [base[0], base[1], order.first * order.kept("base")[3]]
    for name, force in (("cart_damping", (order.cart_rate(0), order.cart_rate(1))), ("cart_rubbed", order.cart_friction())):
        if name in order.layout and force is not None:
            answers = order.kept(name)
            made = [value - (answers[2 * row] * force[0] + answers[2 * row + 1] * force[1]) for row, value in enumerate(made)]
    for row in range(3):
        for i, entry in enumerate(loads):
            made[row] = made[row] + entries[len(loads) * row + i] * entry
        made[row] = order.builder.let(("base_x", "base_y", "base_stretch")[row], made[row])
    order.write_cart((made[0] * length, made[1] * length))
    sweep.outwards((made[0], made[1], base[2]), made[2])


class _Order:
    """The arrays of one order: c, d and g of every link's outer chain."""

    def __init__(self, order: Ordering) -> None:
        self.order, self.builder, self.links = order, order.builder, order.scene.links
        self.pull, self.push = self.builder.array("pull", self.links), self.builder.array("push", load_size(order.scene) * self.links)
        self.eased, self.drawn = self.builder.array("eased", self.links), self.builder.array("drawn", self.links)
        self.units = SpatialUnits(self.builder, order.scene, order.parameters)
        self.known = self._known()

    def unit(self, name: str) -> ArrayRef:
        """Numbers of the links' own units: constants, or held."""
        kept = f"unit_{name}"
        return self.order.kept(kept) if kept in self.order.layout else getattr(self.units, name)

    def _known(self) -> ArrayRef:
        """Y_k: the sums and the couples."""
        order = self.order
        if order.couple is None:
            return order.sums
        unit = self.unit("inverse_torque")
        known = self.builder.array("known", 3 * self.links)
        with self.builder.loop("k", 0, self.links) as loop:
            k = loop.index
            store(known, k, add(load(order.sums, k), scale(unit[k], load(order.couple, k))))
        return known

    @property
    def size(self) -> int:
        """Numbers of a load beside its pull."""
        return load_size(self.order.scene)

    def number(self, name: str, k: Index) -> Expr:
        return self.order.kept(name)[k]

    def vector(self, name: str, k: Index, size: int = 3) -> Vector:
        return load(self.order.kept(name), k, size)

    def rows(self, name: str, k: Index, count: int, width: int) -> Matrix:
        return tuple(load(self.order.kept(name), count * k + i, width) for i in range(count))

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
        pressed = applied(self.matrix("passed", k), known)
        if self.size > 3:
            pressed = (*pressed, *applied(self.rows("passed_minor", k, 3, 3), known))
        pressed = sub(pressed, scale(along, self.vector("push_along", k, self.size)))
        self.pull[k] = pull
        store(self.push, k, (nothing,) * self.size if push is None else push)
        if push is not None:
            drawn = drawn + dot(self.vector("pull_push", k, self.size), push) + self.number("pull_pull", k) * pull
            back = applied(self.rows("push_push", k, self.size, self.size), push)
            pressed = sub(pressed, add(back, scale(pull, self.vector("push_pull", k, self.size))))
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
        push, pull = load(self.push, k, self.size), self.pull[k]
        is_steep = self.size > 3 and not is_tip
        across = applied(self.matrix("reply", k), pressed if is_tip or is_steep else sub(pressed, push))
        if is_steep:
            across = sub(across, applied(self.rows("free_push", k, 3, self.size), push))
        if not is_tip:
            across = sub(sub(across, scale(pull, self.vector("free_pull", k))), scale(axial, self.vector("turned", k)))
        multiplier = self.number("force_axial", k) * stretch - dot(q, known)
        bent = add(sub(across, joint), scale(dot(q, joint) + along, q))
        tip, beyond = joint, axial
        if not is_tip:
            tip = add(across, scale(axial, q))
            beyond = self.number("stretch_axial", k) * axial + dot(self.vector("stretch_known", k), pressed)
            beyond = beyond + (self.number("stretch_pull", k) * pull + dot(self.vector("stretch_push", k, self.size), push))
            beyond = self.builder.let("stretch_next", beyond)
            multiplier = multiplier + self.unit("overhang")[k] * dot(q, push[:3])
            multiplier = multiplier + dot(self.vector("force_joint", k), tip) + self.number("force_stretch", k) * beyond
        order.write(k, bent, self.builder.lift(1), multiplier)
        return tip, beyond
