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
from phichain.lowering.algebra.vector import Vector, cross, load, store, sub
from phichain.lowering.chain.base import carried
from phichain.lowering.chain.body import point_masses
from phichain.lowering.chain.losses import slows_joints
from phichain.lowering.chain.parameters import Parameters
from phichain.lowering.chain.units import units_of_links
from phichain.lowering.series.held import Layout
from phichain.lowering.series.series import HELD, LEFT, LOST, RIGHT, RUB_LANES, SCALE
from phichain.lowering.series.shape import shaped
from phichain.lowering.series.spatial.couples import keep_rests
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
    parameters = Parameters(builder, model, units_of_links(scene), scene)
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
