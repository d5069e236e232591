"""One order of a spatial chain's recurrences: what each form solves for, and where its coefficients go.

One trajectory keeps left and right rows as they are multiplied, each multiplier thrice, and its state's coefficients apart, as a
vector takes a row. Trajectories side by side keep what every number is, once: row n + 2 of the configuration, which is left row n + 1
behind its cart's, and every multiplier; the rates' coefficients are (n + 1) q_{n+1}, and the three squares of a link come as one sum.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction

from phichain.ir.builder import ArrayRef, Builder, Expr, Index
from phichain.ir.nodes import Program
from phichain.lowering.algebra.vector import Vector, load, scale, store
from phichain.lowering.chain.body import point_masses
from phichain.lowering.chain.parameters import Parameters
from phichain.lowering.chain.units import units_of_links
from phichain.lowering.series.held import Layout
from phichain.lowering.series.series import (
    COEFFICIENT,
    HELD,
    LEFT,
    NEXT,
    NOW,
    RIGHT,
    ROW,
    ROW_AFTER,
    ROW_AHEAD,
    RUB_SUMS,
    SUMS,
)
from phichain.lowering.series.shape import shaped, with_rates_in_a_loop
from phichain.lowering.series.spatial.couples import Joints
from phichain.lowering.series.spatial.rows import Number, left_width, right_rows
from phichain.lowering.series.spatial.rubs import Rubs, places
from phichain.lowering.spatial.links import directions
from phichain.mechanics import Model
from phichain.scene import Scene


class Rows(ABC):
    """Where an order finds the sums and coefficients before it, and writes its own.

    Attributes:
        sums: the products of left and right rows, lane by lane.
        rub_sums: those of dry friction, behind the others.
        coefficient: the state's coefficients of order n, [q, rate].
        left: left row n + 1.
        now: n + 1, 1/(n + 1), 1/((n + 1)(n + 2)), whether n = 0.
        turned: right row n + 1, from where the row of multipliers would begin if it had three lanes a link.
    """

    sums: ArrayRef
    rub_sums: ArrayRef
    coefficient: ArrayRef
    now: ArrayRef
    left: ArrayRef
    turned: ArrayRef

    @abstractmethod
    def square(self, k: Index) -> Expr:
        """The squares of a link's three lanes."""

    @abstractmethod
    def link(self, k: Index, acceleration: Vector, inverse_length: Expr, multiplier: Expr) -> None:
        """Write link k, whose q''_n is acceleration * inverse_length."""

    @abstractmethod
    def cart(self, i: int, acceleration: Expr, length: Expr | Fraction) -> None:
        """Write an axis of the cart, whose x''_n is acceleration * length."""


class RowsApart(Rows):
    """Those of one trajectory."""

    def __init__(self, builder: Builder, scene: Scene) -> None:
        rows, lanes = right_rows(scene), 3 * scene.links
        self._builder, self._scene = builder, scene
        self.sums = builder.input(SUMS, ((rows + 1) * lanes + RUB_SUMS * places(scene),), "convolutions of left and right, and of left with itself")
        self._squares, self.rub_sums = self.sums.shifted(rows * lanes), self.sums.shifted((rows + 1) * lanes)
        self.coefficient = builder.input(COEFFICIENT, (scene.nq + scene.nv,), "the state's coefficients of order n")
        self.now = builder.input(NOW, (4,), "n + 1, 1/(n + 1), 1/((n + 1)(n + 2)), 1 at order 0")
        self.left = builder.output(LEFT, (left_width(scene),), "row n + 1")
        self.turned = self._right = builder.output(RIGHT, (rows * lanes,), "row n + 1")
        self._next = builder.output(NEXT, (scene.nq + scene.nv,), "the state's coefficients of order n + 1")
        with builder.loop("k", 0, scene.nq) as loop:
            self._next[loop.index] = self.coefficient[loop.index + scene.nq] * self.now[1]

    def square(self, k: Index) -> Expr:
        x, y, z = load(self._squares, k)
        return x + y + z

    def link(self, k: Index, acceleration: Vector, inverse_length: Expr, multiplier: Expr) -> None:
        rate, ahead = self._builder.let("rate_unit", self.now[1] * inverse_length), self.now[2] * inverse_length
        store(self.left, k, scale(self._builder.let("ahead_unit", ahead), acceleration))
        store(directions(self._scene, self._next.shifted(self._scene.nq)), k, scale(rate, acceleration))
        store(self._right, k, (multiplier, multiplier, multiplier))

    def cart(self, i: int, acceleration: Expr, length: Expr | Fraction) -> None:
        self._next[self._scene.nq + i] = acceleration * (self.now[1] * length)


class RowsShared(Rows):
    """Those of trajectories side by side."""

    def __init__(self, builder: Builder, scene: Scene) -> None:
        rows, lanes, carts = right_rows(scene), 3 * scene.links, 2 * scene.has_cart
        self._builder, self._scene = builder, scene
        self.sums = builder.input(SUMS, (rows * lanes + scene.links + RUB_SUMS * places(scene),), "convolutions of left and right, and squares by link")
        self._squares, self.rub_sums = self.sums.shifted(rows * lanes), self.sums.shifted(rows * lanes + scene.links)
        row = builder.input(ROW, (carts + left_width(scene),), "row n of the configuration")
        after = builder.input(ROW_AFTER, (carts + left_width(scene),), "row n + 1 of the configuration")
        self.now = builder.input(NOW, (4,), "n + 1, 1/(n + 1), 1/((n + 1)(n + 2)), 1 at order 0")
        self._row = builder.output(ROW_AHEAD, (carts + left_width(scene),), "row n + 2 of the configuration")
        self._right = builder.output(RIGHT, (scene.links + (rows - 1) * lanes,), "row n + 1")
        self.left, self.turned = self._row.shifted(carts), self._right.shifted(scene.links - lanes)
        self.coefficient = builder.array("coefficients", scene.nq + scene.nv)
        with builder.loop("k", 0, scene.nq) as loop:
            self.coefficient[loop.index] = row[loop.index]
            self.coefficient[loop.index + scene.nq] = after[loop.index] * self.now[0]

    def square(self, k: Index) -> Expr:
        return self._squares[k]

    def link(self, k: Index, acceleration: Vector, inverse_length: Expr, multiplier: Expr) -> None:
        store(self.left, k, scale(self._builder.let("ahead_unit", self.now[2] * inverse_length), acceleration))
        self._right[k] = multiplier

    def cart(self, i: int, acceleration: Expr, length: Expr | Fraction) -> None:
        self._row[i] = acceleration * (self.now[2] * length)


@dataclass
class Ordering:
    """`flow_order` being written.

    Attributes:
        rows: where coefficients are found and go.
        couple: the couples n_k of springs and dampers at this order, three cells a link, or None.
        along: q_0.q''_n of a link, known from the squares.
        first: 1 at order 0, else 0: what is constant in time goes with it.
    """

    builder: Builder
    scene: Scene
    parameters: Parameters
    layout: Layout
    held: ArrayRef
    rows: Rows
    couple: ArrayRef | None
    along: Callable[[Index], Expr]
    first: Expr
    rubs: Rubs

    @property
    def sums(self) -> ArrayRef:
        """The products of left and right rows."""
        return self.rows.sums

    def cart_friction(self) -> Vector | None:
        """The dry friction of a cart at this order, over the unit it was held in; None without."""
        if self.rubs.cart is None:
            return None
        rate = (self.cart_rate(0), self.cart_rate(1), self.builder.lift(0))
        return self.rubs.resisted(self.rubs.cart, rate, self.rows.rub_sums, self.first)

    def kept(self, name: str) -> ArrayRef:
        """What `flow_factor` held."""
        return self.layout.of(self.held, name)

    def number(self, number: Number) -> ArrayRef:
        """A number of every link."""
        return self.kept(number.name) if number.name in self.layout else number.table(self.parameters)

    def cart_rate(self, axis: int) -> Expr:
        """The coefficient of x', in the scene's own unit of length."""
        return self.rows.coefficient[self.scene.nq + axis]

    def write(self, k: Index, acceleration: Vector, inverse_length: Expr, multiplier: Expr) -> None:
        """The coefficients of link k: q''_n = acceleration * inverse_length, and mu_n."""
        self.rows.link(k, acceleration, inverse_length, multiplier)

    def write_driven(self) -> None:
        """The rate of a cart that is driven by its acceleration, which is constant over a step."""
        if self.scene.is_driven:
            self.write_cart((self.first * self.kept("push")[0], self.first * self.kept("push")[1]))

    def write_cart(self, acceleration: tuple[Expr, Expr]) -> None:
        """The cart's rate, from x''_n in the scene's own unit of length."""
        for i, entry in enumerate(acceleration):
            self.rows.cart(i, entry, self.parameters.units.length)


def order_program(model: Model, layout: Layout, write: Callable[[Ordering], None], rows_of: Callable[[Builder, Scene], Rows] = RowsApart) -> Program:
    """`flow_order`: everything but the solution for q''_n and mu_n, which `write` adds."""
    scene = point_masses(model.scene)
    builder = Builder("flow_order", "The coefficients of the next order.")
    parameters = Parameters(builder, model, units_of_links(scene), scene)
    held = builder.input(HELD, (layout.size,), "constants of the step")
    rows = rows_of(builder, scene)
    now = rows.now
    bend = builder.let("bend_unit", (now[0] * now[0] + now[0]) * -0.5)

    def along(k: Index) -> Expr:
        return bend * rows.square(k)

    rubs = Rubs(builder, scene, layout, held, rows.left)
    joints = Joints(builder, scene, layout, held, rows.sums, rows.coefficient, rows.turned, now[3], rubs, rows.rub_sums)
    write(Ordering(builder, scene, parameters, layout, held, rows, joints.couples(), along, now[3], rubs))
    made = shaped(builder.finish(), scene.code)
    return made if scene.varied else with_rates_in_a_loop(made, scene.nq)
