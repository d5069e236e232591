"""The numbers of a Model inside a Program: exact constants where they are known, cells of the params struct where not.

Coefficients that are numbers are those of the Model's Lagrangian. Those of runtime parameters are computed by recurrences
from the params struct, and `agreement` holds these, and the masses and lengths that structured forms use one by one, against
the Lagrangian.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from copy import copy
from fractions import Fraction
from itertools import pairwise
from math import inf, prod

from phichain.ir.builder import ArrayRef, Builder, Expr, Index
from phichain.lowering.chain.body import Bodies, Links, is_folded
from phichain.lowering.chain.units import Units
from phichain.mechanics import Model
from phichain.mechanics.symbols import Coefficient
from phichain.scene import Scene
from phichain.scene.keys import PER_LINK

_DOC = {
    "mass": "point mass of each link, kg",
    "length": "length of each link, m",
    "com": "distance of each point mass from its base joint, m",
    "cart_mass": "mass of the cart, kg",
    "gravity": "gravitational acceleration, m/s^2",
    "damping": "damping of each joint, N m s/rad",
    "stiffness": "stiffness of each joint, N m/rad",
    "inertia": "moment of inertia of each link about its centre of mass, kg m^2",
    "armature": "inertia of the rotor at each joint, kg m^2",
    "friction": "dry friction of each joint, N m",
    "cart_damping": "damping of the cart, N s/m",
    "cart_friction": "dry friction of the cart, N",
    "rest_angle": "angle of each joint at which its spring rests, rad",
}

_RIGID_DOC = {"mass": "mass of each link, kg", "com": "distance of each centre of mass from its link's base joint, m"}


def _numbers(coefficients: Sequence[Coefficient], unit: Fraction) -> list[Fraction]:
    """Coefficients in a unit, if all are numbers; else none."""
    known = [entry / unit for entry in coefficients if isinstance(entry, Fraction)]
    return known if len(known) == len(coefficients) else []


class Parameters:
    """Per-link parameters and the sums of theory section 1 that lowering needs, each made on first use.

    Links are counted from 0. ``outer_mass[k]`` is the mass beyond link k, ``mu[k] = m_k r_k + l_k outer_mass[k]``,
    ``c_diagonal[k] = m_k r_k^2 + J_k + l_k^2 outer_mass[k]``; for i != j ``c_ij = length[min(i, j)] * mu[max(i, j)]``.
    """

    def __init__(self, builder: Builder, model: Model, units: Units | None = None, scene: Scene | None = None) -> None:
        """Declare the runtime parameters and read the numbers.

        Args:
            builder: where the Program is recorded.
            model: the chain's mechanics.
            units: what to measure in, SI units where none are given; the caller converts inputs and results.
            scene: the chain whose masses and lengths to give instead of the model's own (`body.point_masses`).
        """
        scene = scene or model.scene
        self._builder, self._model, self._scene = builder, model, scene
        self._bodies: Bodies | None = None
        self.units = units or Units()
        self._made: dict[str, ArrayRef] = {}
        self._base: tuple[Expr, ...] = ()
        self.links = scene.links
        for name in scene.runtime:
            shape = (scene.links,) if name in PER_LINK else ()
            self._made[name] = builder.param(name, shape, (_DOC if scene.inertia is None else _DOC | _RIGID_DOC)[name])
        self.mass = self._given("mass")
        self.length = self._given("length")
        self.com = self.length if scene.com is None else self._given("com")

    @property
    def damping(self) -> ArrayRef | None:
        """Joint damping, or None on an undamped scene."""
        return None if self._scene.damping is None else self._given("damping")

    @property
    def stiffness(self) -> ArrayRef | None:
        """Joint stiffness, or None on a scene without springs."""
        return None if self._scene.stiffness is None else self._given("stiffness")

    @property
    def inertia(self) -> ArrayRef | None:
        """Moments of inertia about the links' centres of mass, or None on a scene of point masses."""
        return None if self._scene.inertia is None else self._given("inertia")

    @property
    def bodies(self) -> Bodies | None:
        """Moments of the links about their joints, or None on a scene of point masses."""
        if self._bodies is None and self.inertia is not None:
            with self._builder.first_of_all():
                links = Links(self.mass, self.length, self.com, self.inertia)
                self._bodies = Bodies(self._builder, self._scene, links, self.derived)
        return self._bodies

    @property
    def armature(self) -> ArrayRef | None:
        """The rotors' inertias, or None on a scene without rotors."""
        return None if self._scene.armature is None else self._given("armature")

    @property
    def friction(self) -> ArrayRef | None:
        """Dry friction of the joints, or None on a scene without."""
        return None if self._scene.friction is None else self._given("friction")

    @property
    def rest_angle(self) -> ArrayRef | None:
        """Angles at which the joints' springs rest, or None where all rest at zero."""
        return None if self._scene.rest_angle is None else self._given("rest_angle")

    @property
    def cart_damping(self) -> Expr | None:
        """Damping of the cart, or None without."""
        return None if self._scene.cart_damping is None else self._scalar("cart_damping")

    @property
    def cart_friction(self) -> Expr | None:
        """Dry friction of the cart, or None without."""
        return None if self._scene.cart_friction is None else self._scalar("cart_friction")

    @property
    def none(self) -> Expr:
        """Zero."""
        return self._builder.lift(0)

    @property
    def gravity(self) -> Expr:
        """Gravitational acceleration."""
        return self._scalar("gravity")

    @property
    def fall(self) -> tuple[Expr, ...]:
        """Gravity less the acceleration of the base, the last of d components down: what a chain falls with, seen from there."""
        zero, size = self._builder.lift(0), 2 if self._scene.is_planar else 3
        still = (*(zero for _ in range(size - 1)), self.gravity)
        if not self._base:
            return still
        return tuple(own - given / self.units.acceleration for own, given in zip(still, self._base, strict=True))

    def carried(self, scene: Scene, acceleration: tuple[Expr, ...]) -> Parameters:
        """The same numbers as sweeps see them over a base with a given acceleration (m/s^2): those of another scene, on a wall."""
        numbers = copy(self)
        numbers._scene, numbers._base = scene, acceleration
        return numbers

    @property
    def cart_mass(self) -> Expr:
        """Mass of the cart, zero for one that is driven and weighs nothing; with it what rigid links leave there as point masses."""
        if self._scene.cart_mass is None:
            return self._builder.lift(0)
        mass, own = self._scalar("cart_mass"), self._model.scene
        if self._scene.cart_mass != "runtime" or self._scene.inertia is own.inertia:
            return mass
        left = sum(map(Fraction, own.mass)) - sum(map(Fraction, self._scene.mass))
        return mass + left / self.units.mass

    @property
    def base_mass(self) -> Expr:
        """Mass of the cart, with what rigid links leave at the joint on it (`body`)."""
        return self.cart_mass if self.bodies is None else self.cart_mass + self.bodies.left

    @property
    def outer_mass(self) -> ArrayRef:
        """The mass beyond each link, sum of m_a over a > k."""
        return self._once("outer_mass", self._outer_mass)

    @property
    def total_mass(self) -> Expr:
        """M_00 = m_0 + sum of all m_a."""
        if isinstance(self._model.total_mass, Fraction):
            return self._builder.lift(self._model.total_mass / self.units.mass)
        chain = self.outer_mass[0] + self.mass[0]
        return chain + self.cart_mass if self._scene.has_cart else chain

    @property
    def mu(self) -> ArrayRef:
        """First moments mu_k."""
        if known := _numbers(self._model.mu, self.units.mass * self.units.length):
            return self._once("mu", lambda: self._builder.constants("mu", known))
        return self.derived("mu", lambda k: self.mass[k] * self.com[k] + self.length[k] * self.outer_mass[k])

    @property
    def c_diagonal(self) -> ArrayRef:
        """Second moments c_kk."""
        if known := _numbers(self._model.c_diagonal, self.units.inertia):
            return self._once("c_diagonal", lambda: self._builder.constants("c_diagonal", known))
        length, com, inertia = self.length, self.com, self.inertia

        def moment(k: Index) -> Expr:
            own = self.mass[k] * com[k] * com[k]
            own = own if inertia is None else own + inertia[k]
            return own + length[k] * length[k] * self.outer_mass[k]

        return self.derived("c_diagonal", moment)

    @property
    def mass_ratio(self) -> ArrayRef:
        """rho_k = m_k / m_{k-1} for k = 1..N; the last, beyond the tip (where the tension is zero), repeats its neighbour."""
        return self._between("mass_ratio", lambda k: self.mass[k + 1] / self.mass[k])

    @property
    def inverse_mass_ratio(self) -> ArrayRef:
        """1 / rho_k = m_{k-1} / m_k for k = 1..N, padded likewise."""
        return self._between("inverse_mass_ratio", lambda k: self.mass[k] / self.mass[k + 1])

    @property
    def real(self) -> str:
        """The scene's number type."""
        return self._scene.real

    @property
    def pivot_growth(self) -> float:
        """Bound of how far pivots of the tension system grow on either side; infinite where masses are runtime."""
        scene = self._scene
        if isinstance(scene.mass, str) or isinstance(scene.cart_mass, str):
            return inf
        ratios = [outer / inner for inner, outer in pairwise((scene.cart_mass or scene.mass[0], *scene.mass))]
        middle = (self.links - 1) // 2
        return max(prod(1 + ratio for ratio in ratios[:middle]), prod(1 + 1 / ratio for ratio in ratios[middle + 1 :]))

    def derived(self, name: str, entry: Callable[[Index], Expr], count: int | None = None) -> ArrayRef:
        """A table of per-link values made once per Program."""
        return self._once(name, lambda: self._builder.table(name, count or self.links, entry))

    def steps(
        self, name: str, unit: Callable[[Index], Expr], inverse: Callable[[Index], Expr] | None = None
    ) -> ArrayRef:
        """unit(k) / unit(k - 1) for each link, by a product where the inverse is known; 1 for the link at the base."""

        def step(k: Index) -> Expr:
            return unit(k) * inverse(k - 1) if inverse else unit(k) / unit(k - 1)

        if is_folded(self._scene):
            return self.derived(name, lambda k: step(k) if k else self._builder.lift(1))
        return self._once(name, lambda: self._step_cells(name, step))

    def _step_cells(self, name: str, step: Callable[[Index], Expr]) -> ArrayRef:
        builder = self._builder
        cells = builder.array(name, self.links)
        cells[0] = builder.lift(1)
        with builder.loop("k", 1, self.links) as loop:
            cells[loop.index] = step(loop.index)
        return cells

    def _between(self, name: str, entry: Callable[[Index], Expr]) -> ArrayRef:
        """entry(k - 1) for the neighbours k - 1 and k, k = 1..N-1, and a repeated entry for k = N."""
        if isinstance(self._scene.mass, str) and self.links > 1:
            return self._once(name, lambda: self._padded(name, entry)).shifted(-1)
        known = [entry(k).constant or Fraction(1) for k in range(self.links - 1)]
        padded = [*known, known[-1] if known else Fraction(1)]
        return self._once(name, lambda: self._builder.constants(name, padded)).shifted(-1)

    def _padded(self, name: str, entry: Callable[[Index], Expr]) -> ArrayRef:
        builder, last = self._builder, self.links - 1
        cells = builder.array(name, self.links)
        with builder.loop("k", 0, last) as loop:
            cells[loop.index] = entry(loop.index)
        cells[last] = builder.lift(1)
        return cells

    def _outer_mass(self) -> ArrayRef:
        builder, links = self._builder, self.links
        if self._scene.mass != "runtime":
            exact = [self.mass[k].constant or Fraction(0) for k in range(links)]
            return builder.constants("outer_mass", [sum(exact[k + 1 :], Fraction(0)) for k in range(links)])
        outer = builder.array("outer_mass", links)
        outer[links - 1] = builder.lift(0)
        with builder.loop("k", links - 1, 0, -1) as loop:
            k = loop.index
            beyond = loop.carry("beyond", 0)
            following = beyond + self.mass[k]
            outer[k - 1] = following
            loop.follow(beyond, following)
        return outer

    def _given(self, name: str) -> ArrayRef:
        unit = self.units.of(name)
        exact = [Fraction(value) / unit for value in getattr(self._scene, name)] if name not in self._made else []
        return self._once(name, lambda: self._builder.constants(name, exact))

    def _scalar(self, name: str) -> Expr:
        if name in self._made:
            return self._made[name][0]
        return self._builder.lift(Fraction(getattr(self._scene, name)) / self.units.of(name))

    def _once(self, name: str, make: Callable[[], ArrayRef]) -> ArrayRef:
        if name not in self._made:
            with self._builder.first_of_all():
                self._made[name] = make()
        return self._made[name]
