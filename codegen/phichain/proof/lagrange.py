"""The judge: what the Model's own Lagrangian says of a motion, evaluated in the field with nilpotent directions.

For coordinates x (angles, or unit vectors as vectors of space) the virtual work along dx is

    [d/dt dT/dx' - dT/dx + dV/dx].dx + dR/drate.eta = u.eta

d/dt dT/dx'.dx is the mixed derivative of T along (x', x'') in (x, x') and along dx in x'; the others are first derivatives. On the
sphere dx_k = eta_k x q_k, x_k' = omega_k x q_k and x_k'' = omega_k' x q_k + omega_k x x_k': Lagrange and d'Alembert's principle.
So one residual costs two evaluations of T, V and R, however long the chain is.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Final

import sympy

from phichain.ir.nodes import Affine, Array, Cell, Operand, Program
from phichain.ir.passes import prune
from phichain.mechanics import Model
from phichain.mechanics.energies import names_of
from phichain.mechanics.symbols import parameter, single
from phichain.proof.modular.compiled import Circle, Compiled, Given, compiled
from phichain.proof.modular.field import PRIME, Vector, cross, plus
from phichain.proof.modular.points import Point
from phichain.proof.modular.symbolic import as_program, cells
from phichain.scene import Scene
from phichain.scene.keys import PER_LINK


@dataclass(frozen=True)
class Work:
    """Virtual work along one direction, by where it comes from; forces on the left side of the equations of motion.

    Attributes:
        inertia: that of T.
        weight: gravity's part of V.
        potential: all of V.
        dampers: that of R.
    """

    inertia: int
    weight: int
    potential: int
    dampers: int

    @property
    def whole(self) -> int:
        """All of it."""
        return self.inertia + self.potential + self.dampers


@dataclass(frozen=True)
class Motion:
    """A state of the chain in the Lagrangian's coordinates, and how it moves.

    Attributes:
        x: coordinates.
        rate: x'.
        acceleration: x''.
        omega: what dampers see: v.
        base: acceleration of a moving base; none where it moves steadily.
    """

    x: Vector
    rate: Vector
    acceleration: Vector
    omega: Vector
    base: Vector = field(default_factory=list)


BASE_RATE: Final = "base_rate"
"""The velocity of a moving base: an argument of a Judge's Program, and no coordinate."""


def along_told(scene: Scene, given: Vector) -> Vector:
    """All components of the acceleration of a base that has no coordinates, by those at the head of its inputs."""
    known = dict(zip(scene.told_axes, given, strict=False))
    return [known.get(axis, 0) for axis in range(scene.dimensions)]


ENERGIES: Final = ("kinetic", "potential", "dissipation")
"""Outputs of a Judge's Program that are T, V and R."""


class Judge:
    """A Model's Lagrangian, compiled once.

    Attributes:
        scene: the chain.
        program: T, V, R and the positions as a Program of (q, v) and, in space, `rate`.
        rate: the argument that x' is.
    """

    def __init__(self, model: Model, params: Sequence[Array]) -> None:
        """Compile T, V, R and the positions.

        Args:
            model: whose Lagrangian.
            params: fields of the scene's runtime parameters.
        """
        scene, symbols, energies, names = model.scene, model.symbols, model.energies, names_of(model.scene)
        self.scene = scene
        inputs = [Array("q", (scene.nq,)), Array("v", (scene.nv,)), *params]
        known = cells(inputs[0], symbols.q) | cells(inputs[1], symbols.v) | runtime_cells(scene)
        self.rate = "v"
        if not scene.is_planar:
            self.rate = "q_dot"
            inputs.append(Array("q_dot", (scene.nq,)))
            known |= cells(inputs[-1], [*symbols.cart_rate, *(entry for link in symbols.link_rates for entry in link)])
        if scene.is_moving:
            inputs.append(Array(BASE_RATE, (scene.base_inputs,)))
            known |= cells(inputs[-1], symbols.base_rate)
        links = range(1, scene.links + 1)
        weight = energies.potential.xreplace({names.bend(k): sympy.S.Zero for k in links})
        outputs = {
            "kinetic": [energies.kinetic],
            "weight": [weight],
            "potential": [energies.potential],
            "dissipation": [energies.dissipation],
            "positions": [entry for k in links for entry in names.mass(k)],
        }
        self.program = as_program("lagrangian", inputs, known, energies.definitions, outputs)
        self._run: Compiled = compiled(self.program, 2)

    @cached_property
    def energy_program(self) -> Program:
        """T, V and R alone."""
        outputs = {array.name: array for array in self.program.outputs}
        return prune(replace(self.program, outputs=tuple(outputs[name] for name in ENERGIES)))

    def motion(self, point: Point, v: Vector | None = None, a: Vector | None = None) -> Motion:
        """The motion of a point with rates v (its own where not given) and accelerations a (none where not given)."""
        v = point.v if v is None else v
        a = [0] * len(v) if a is None else a
        rate = self.turned(point, v)
        acceleration = self.turned(point, a)
        if not self.scene.is_planar:
            acceleration = plus(acceleration, [0] * point.carts + list(triples(rate, v, point.carts)))
        return Motion(point.q, rate, acceleration, v)

    def drift(self, point: Point) -> dict[str, Vector]:
        """Some velocity of a moving base: of the equations of motion none may feel it."""
        return {BASE_RATE: point.free("base rate", self.scene.base_inputs)} if self.scene.is_moving else {}

    def balance(self, point: Point, motion: Motion, turn: Vector) -> int:
        """What a motion under the point's inputs leaves of the equations of motion along a direction: zero.

        Lagrange and d'Alembert for everything that forces move, x'' = u for a cart that is driven by its acceleration.
        """
        told = point.carts if self.scene.is_driven else 0
        moved = replace(motion, base=point.u[: self.scene.base_inputs]) if self.scene.is_moving else motion
        left = self.work(point, moved, [*[0] * told, *turn[told:]]).whole - self.push(point, turn)
        return left + sum(turn[i] * (motion.acceleration[i] - point.u[i]) for i in range(told))

    def turned(self, point: Point, turn: Vector) -> Vector:
        """What rates do to the coordinates: themselves in the plane, eta_k x q_k in space."""
        if self.scene.is_planar:
            return turn
        return turn[: point.carts] + list(triples(point.q, turn, point.carts))

    def work(self, point: Point, motion: Motion, turn: Vector) -> Work:
        """The virtual work of a motion along the rotations (or angles) `turn`."""
        shift = self.turned(point, turn)
        values = {"q": motion.x, "v": motion.omega, self.rate: motion.rate, **self.drift(point)}
        ahead = {"q": motion.rate, self.rate: motion.acceleration} | ({BASE_RATE: motion.base} if motion.base else {})
        timed = self.evaluate(point, values, along=ahead, across={"v": turn, self.rate: shift})
        still = self.evaluate(point, values, along={"q": shift})
        return Work(
            inertia=timed["kinetic"][3][0] - still["kinetic"][1][0],
            weight=still["weight"][1][0],
            potential=still["potential"][1][0],
            dampers=timed["dissipation"][2][0],
        )

    def evaluate(
        self, point: Point, values: dict[str, Vector], circles: list[Circle] | None = None, **directions: dict[str, Vector]
    ) -> dict[str, tuple[list[int], ...]]:
        """T, V, R and the positions with their derivatives along the directions; a moving base rests unless its rate is given."""
        if self.scene.is_moving:
            values = {BASE_RATE: [0] * self.scene.base_inputs} | values
        turns = {"q": point.circles if circles is None else circles} if self.scene.is_planar else {}
        return self._run(Given(point.parameters | values, turns, **directions), point)

    def energies(self, point: Point, drift: bool = False) -> dict[str, list[int]]:
        """T, V's parts, R and the positions of a point; seen from a moving base, or from where that drifts."""
        motion = self.motion(point)
        values = {"q": motion.x, "v": motion.omega, self.rate: motion.rate, **(self.drift(point) if drift else {})}
        return {name: parts[0] for name, parts in self.evaluate(point, values).items()}

    def kinetic_form(self, point: Point, one: Vector, other: Vector) -> int:
        """The bilinear form of 2 T at a configuration, for two vectors of x'."""
        zero = [0] * self.scene.nq
        values = {"q": point.q, "v": zero, self.rate: zero}
        parts = self.evaluate(point, values, along={self.rate: one}, across={self.rate: other})
        return parts["kinetic"][3][0]

    def momentum(self, point: Point, motion: Motion, shift: Vector) -> int:
        """dT/dx' along dx."""
        values = {"q": motion.x, "v": motion.omega, self.rate: motion.rate}
        return self.evaluate(point, values, along={self.rate: shift})["kinetic"][1][0]

    def push(self, point: Point, turn: Vector) -> int:
        """The virtual work of the forces among the point's inputs: on the cart, then on the actuated angles."""
        forces = point.u[self.scene.base_accelerations :]
        return sum(u * turn[i] for u, i in zip(forces, self.scene.driven, strict=True)) % PRIME


def triples(vectors: Vector, turns: Vector, start: int) -> Iterable[int]:
    """turn_k x vector_k for every link, the entries before `start` left out."""
    for k in range(start, len(vectors), 3):
        yield from cross(turns[k : k + 3], vectors[k : k + 3])


def runtime_cells(scene: Scene) -> dict[sympy.Symbol, Operand]:
    """The cells of the parameters that come at run time."""
    known: dict[sympy.Symbol, Operand] = {}
    for name in scene.runtime:
        symbols = parameter(scene, name) if name in PER_LINK else [single(scene, name)]
        known |= {symbol: Cell(name, Affine(k)) for k, symbol in enumerate(symbols)}
    return known
