"""What the Taylor recurrences of all spatial chains share: the rows that are convolved, springs and dampers.

Rows, three lanes a link:

    left_j = q_{j+1},   right_j = [mu_{j-1} thrice] and with dampers [v_{j-1}, Omega_{j-1}, each turned by one and by two axes]

mu the link's multiplier, v = q', Omega_k = d_k omega_{k-1} + d_{k+1} omega_{k+1} and rows 0 of right zero. So the sums of order n
are the parts of (mu q)_n, (q x v)_n and (q x Omega)_n that lean on q_1, q_2, ... alone, and the squares, over the three lanes of a
link, those of (q.q)_{n+2}: with q.q = 1

    q_0.q''_n = -(n + 1)(n + 2) / 2 squares_n

Springs and dampers: `couples`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from phichain.ir.builder import ArrayRef, Builder, Expr, Index
from phichain.ir.nodes import Program
from phichain.lowering.algebra.vector import Vector, cross, load, scale, store, sub
from phichain.lowering.chain.base import carried
from phichain.lowering.chain.body import point_masses
from phichain.lowering.chain.losses import slows_joints
from phichain.lowering.chain.parameters import Parameters
from phichain.lowering.series.held import Layout
from phichain.lowering.series.series import (
    COEFFICIENT,
    HELD,
    LEFT,
    LOST,
    NEXT,
    NOW,
    RIGHT,
    RUB_LANES,
    RUB_SUMS,
    SCALE,
    SUMS,
)
from phichain.lowering.series.shape import shaped
from phichain.lowering.series.spatial.couples import Joints, keep_rests
from phichain.lowering.series.spatial.rubs import Rubs, places
from phichain.lowering.series.spatial.rubs import runs as rub_runs
from phichain.lowering.spatial.links import directions
from phichain.mechanics import Model
from phichain.scene import Scene


def right_rows(scene: Scene) -> int:
    """Right rows of a scene: the multipliers, and with dampers or dry friction two cross products."""
    return 5 if slows_joints(scene) else 1


def joint_runs(scene: Scene) -> list[tuple[str, int]]:
    """What is held of the joints: rho^2 k_k, what rounding took from neighbours' differences, rho d_k, dry friction, and where forces differ from order to order the vertical's length."""
    return [
        ("spring", 0 if scene.stiffness is None else scene.links),
        ("rest", 0 if scene.stiffness is None else 3 * scene.links),
        ("damper", 0 if scene.damping is None else scene.links),
        ("upright", int(scene.forced is not None and scene.stiffness is not None)),
        *rub_runs(scene),
    ]


@dataclass(frozen=True)
class Number:
    """A number of every link that comes of the scene's parameters: a table, or held where those come at run time.

    Attributes:
        name: its name.
        leans_on: names of parameters.
        entry: its value for link k.
    """

    name: str
    leans_on: frozenset[str]
    entry: Callable[[Parameters, Index], Expr]

    def run(self, scene: Scene) -> tuple[str, int]:
        """Its place in what is held."""
        return self.name, scene.links if self.leans_on & set(scene.runtime) else 0

    def table(self, parameters: Parameters) -> ArrayRef:
        """The numbers themselves."""
        return parameters.derived(self.name, lambda k: self.entry(parameters, k))


@dataclass(frozen=True)
class Factoring:
    """`flow_factor` being written.

    Attributes:
        direction: q_k, three cells a link.
        u: inputs, or None.
        rho: unit of time; rates come in it already.
        square: its square.
        held: where the constants of the step go.
    """

    builder: Builder
    scene: Scene
    parameters: Parameters
    layout: Layout
    direction: ArrayRef
    u: ArrayRef | None
    rho: Expr
    square: Expr
    held: ArrayRef
    cart_rate: tuple[Expr, ...]
    rubs: Rubs

    def keep_cart_friction(self, unit: Expr | int) -> None:
        """Hold the dry friction of a cart that moves freely, over a unit of force."""
        force, place = self.parameters.cart_friction, self.rubs.cart
        if force is not None and place is not None:
            rate = (*self.cart_rate, self.builder.lift(0))
            self.rubs.begin(place, rate, self.rho, self.square * (force / unit))

    def keep(self, name: str) -> ArrayRef:
        """Where a quantity is held."""
        return self.layout.of(self.held, name)

    def keep_number(self, number: Number) -> None:
        """Hold a number that is no constant."""
        if number.name in self.layout:
            table = number.table(self.parameters)
            with self.builder.loop("k", 0, self.scene.links) as loop:
                self.keep(number.name)[loop.index] = table[loop.index]

    def keep_driven(self) -> None:
        """Hold the acceleration of a cart that is driven by it, in the scene's own unit of length."""
        if self.scene.is_driven and self.u is not None:
            for i in range(2):
                self.keep("push")[i] = self.u[i] * (1 / self.parameters.units.length) * self.square


def factor_program(model: Model, layout: Layout, write: Callable[[Factoring], None]) -> Program:
    """`flow_factor`: rows 0, the joints' constants, and what `write` adds."""
    scene = point_masses(model.scene)
    builder = Builder("flow_factor", "Factor the mass matrix at the start of a step.")
    parameters = Parameters(builder, model, True, scene)
    q, v = (
        builder.input("q", (scene.nq,), "configuration"),
        builder.input("v", (scene.nv,), "its rates in scaled time"),
    )
    u = builder.input("u", (scene.nu,), "inputs") if scene.nu else None
    parameters = carried(builder, scene, parameters, u).parameters
    unit = builder.input(SCALE, (2,), "unit of time and its square")
    held = builder.output(HELD, (layout.size,), "constants of the step")
    left = builder.output(LEFT, (left_width(scene),), "rates of the unit vectors")
    right = builder.output(RIGHT, (3 * right_rows(scene) * scene.links,), "zeros")
    rate = directions(scene, v)
    with builder.loop("k", 0, scene.links) as loop:
        store(left, loop.index, load(rate, loop.index))
    with builder.loop("k", 0, 3 * right_rows(scene) * scene.links) as loop:
        right[loop.index] = builder.lift(0)
    rubs = Rubs(builder, scene, layout, held, left)
    cart_rate = tuple(v[i] for i in range(2)) if scene.has_free_cart else ()
    factoring = Factoring(builder, scene, parameters, layout, directions(scene, q), u, unit[0], unit[1], held, cart_rate, rubs)
    for name, numbers, by in (
        ("spring", parameters.stiffness, unit[1]),
        ("damper", parameters.damping, unit[0]),
    ):
        if numbers is not None:
            with builder.loop("k", 0, scene.links) as loop:
                factoring.keep(name)[loop.index] = numbers[loop.index] * by
    if "rest" in layout:
        lost = builder.input(LOST, (scene.nq + scene.nv,), "what rounding took from q and v")
        keep_rests(builder, scene.links, directions(scene, lost), factoring.keep("rest"))
    if "upright" in layout:
        factoring.keep("upright")[0] = builder.lift(1)
    if parameters.friction is not None:
        _begin_rubs(factoring, rate, parameters.friction)
    write(factoring)
    return shaped(builder.finish(), scene.code)


def left_width(scene: Scene) -> int:
    """Entries of a left row."""
    return 3 * scene.links + RUB_LANES * places(scene)


def _begin_rubs(step: Factoring, rate: ArrayRef, friction: ArrayRef) -> None:
    """Hold the joints' dry friction."""

    def spin(k: Index) -> Vector:
        return cross(load(step.direction, k), load(rate, k))

    step.rubs.begin(0, spin(0), step.rho, step.square * friction[0])
    with step.builder.loop("k", 1, step.scene.links) as loop:
        k = loop.index
        step.rubs.begin(k, sub(spin(k), spin(k - 1)), step.rho, step.square * friction[k])


@dataclass
class Ordering:
    """`flow_order` being written.

    Attributes:
        couple: the couples n_k of springs and dampers at this order, three cells a link, or None.
        along: q_0.q''_n of a link, known from the squares.
        first: 1 at order 0, else 0: what is constant in time goes with it.
        over: 1/(n + 1) and 1/((n + 1)(n + 2)).
    """

    builder: Builder
    scene: Scene
    parameters: Parameters
    layout: Layout
    held: ArrayRef
    sums: ArrayRef
    coefficient: ArrayRef
    couple: ArrayRef | None
    along: Callable[[Index], Expr]
    first: Expr
    over: tuple[Expr, Expr]
    left: ArrayRef
    right: ArrayRef
    next: ArrayRef
    rubs: Rubs
    rub_sums: ArrayRef

    def cart_friction(self) -> Vector | None:
        """The dry friction of a cart at this order, over the unit it was held in; None without."""
        if self.rubs.cart is None:
            return None
        rate = (self.cart_rate(0), self.cart_rate(1), self.builder.lift(0))
        return self.rubs.resisted(self.rubs.cart, rate, self.rub_sums, self.first)

    def kept(self, name: str) -> ArrayRef:
        """What `flow_factor` held."""
        return self.layout.of(self.held, name)

    def number(self, number: Number) -> ArrayRef:
        """A number of every link."""
        return self.kept(number.name) if number.name in self.layout else number.table(self.parameters)

    def cart_rate(self, axis: int) -> Expr:
        """The coefficient of x', in the scene's own unit of length."""
        return self.coefficient[self.scene.nq + axis]

    def write(self, k: Index, acceleration: Vector, inverse_length: Expr, multiplier: Expr) -> None:
        """Rows n + 1 and the state's coefficients of link k: q''_n = acceleration * inverse_length, and mu_n."""
        rate, ahead = (
            self.builder.let("rate_unit", self.over[0] * inverse_length),
            self.over[1] * inverse_length,
        )
        store(self.left, k, scale(self.builder.let("ahead_unit", ahead), acceleration))
        store(directions(self.scene, self.next.shifted(self.scene.nq)), k, scale(rate, acceleration))
        store(self.right, k, (multiplier, multiplier, multiplier))

    def write_driven(self) -> None:
        """The rate of a cart that is driven by its acceleration, which is constant over a step."""
        if self.scene.is_driven:
            self.write_cart((self.first * self.kept("push")[0], self.first * self.kept("push")[1]))

    def write_cart(self, acceleration: tuple[Expr, Expr]) -> None:
        """The cart's rate, from x''_n in the scene's own unit of length."""
        for i, entry in enumerate(acceleration):
            self.next[self.scene.nq + i] = entry * (self.over[0] * self.parameters.units.length)


def order_program(model: Model, layout: Layout, write: Callable[[Ordering], None]) -> Program:
    """`flow_order`: everything but the solution for q''_n and mu_n, which `write` adds."""
    scene, lanes = point_masses(model.scene), 3 * model.scene.links
    rows = right_rows(scene)
    builder = Builder("flow_order", "The coefficients of the next order.")
    parameters = Parameters(builder, model, True, scene)
    held = builder.input(HELD, (layout.size,), "constants of the step")
    sums = builder.input(
        SUMS, ((rows + 1) * lanes + RUB_SUMS * places(scene),), "convolutions of left and right, and of left with itself"
    )
    coefficient = builder.input(COEFFICIENT, (scene.nq + scene.nv,), "the state's coefficients of order n")
    now = builder.input(NOW, (4,), "n + 1, 1/(n + 1), 1/((n + 1)(n + 2)), 1 at order 0")
    left = builder.output(LEFT, (left_width(scene),), "row n + 1")
    right = builder.output(RIGHT, (rows * lanes,), "row n + 1")
    following = builder.output(NEXT, (scene.nq + scene.nv,), "the state's coefficients of order n + 1")
    with builder.loop("k", 0, scene.nq) as loop:
        following[loop.index] = coefficient[loop.index + scene.nq] * now[1]
    bend = builder.let("bend_unit", (now[0] * now[0] + now[0]) * -0.5)

    def along(k: Index) -> Expr:
        x, y, z = load(sums.shifted(rows * lanes), k)
        return bend * (x + y + z)

    rubs, rub_sums = Rubs(builder, scene, layout, held, left), sums.shifted((rows + 1) * lanes)
    joints = Joints(builder, scene, layout, held, sums, coefficient, right, now[3], rubs, rub_sums)
    write(
        Ordering(
            builder, scene, parameters, layout, held, sums, coefficient, joints.couples(), along, now[3], (now[1], now[2]),
            left, right, following, rubs, rub_sums,
        )
    )  # fmt: skip
    return shaped(builder.finish(), scene.code)
