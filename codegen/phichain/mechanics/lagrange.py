"""Scene -> Model: the Lagrangian of a chain, its exact coefficients and its equations of motion.

`derive` builds the positions of the masses, T and V from them (see `energies`); mu_k, c_ij and M00 are read off
those (see `coefficients`), and all else is made of them when first asked for: nothing here is known from elsewhere,
so another T is another model. Generating code pays for the coefficients alone, while `model.lagrangian`,
`model.mass_matrix` and `model.equations` are there to be read, in SymPy and in LaTeX.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import sympy

from phichain.errors import UnsupportedError
from phichain.mechanics import display
from phichain.mechanics.coefficients import Coefficients
from phichain.mechanics.energies import Energies, energies_of, names_of
from phichain.mechanics.planar import PlanarExpressions
from phichain.mechanics.spatial import SpatialExpressions
from phichain.mechanics.symbols import ChainSymbols, Coefficient, Show, exact, expression
from phichain.scene import Scene, given_scene
from phichain.scene.keys import PARAMETERS


@dataclass(frozen=True)
class Model:
    """The mechanics of one scene.

    Coefficients are exact: `fractions.Fraction` of the scene's binary64 numbers, or SymPy expressions in m_k,
    l_k, r_k, m_0 where parameters are runtime. T and V are exact, too; the other expressions show numbers that are no
    short fractions as decimals.

    Attributes:
        scene: The chain.
        energies: T, V and Rayleigh's function as they follow from the positions of the masses, not multiplied out.
    """

    scene: Scene
    energies: Energies

    @cached_property
    def symbols(self) -> ChainSymbols:
        """The SymPy symbols of coordinates, rates, accelerations and inputs."""
        return ChainSymbols(self.scene)

    @property
    def mu(self) -> tuple[Coefficient, ...]:
        """mu_k (kg m), the first moments: V = -g sum_k mu_k e_d.q_k."""
        return self._chain.mu

    @property
    def c(self) -> tuple[tuple[Coefficient, ...], ...]:
        """c_ij (kg m^2), N x N: T holds 1/2 sum_ij c_ij q_i'.q_j'."""
        return self._chain.c

    @property
    def total_mass(self) -> Coefficient:
        """M00 (kg): the mass of the chain, and of the cart if there is one."""
        return self._chain.total_mass

    @property
    def coupling(self) -> tuple[Coefficient, ...]:
        """The coefficients of x'.C^T q_k' in T (kg m), equal to mu_k; empty on a fixed base."""
        return self._chain.coupling

    @property
    def c_diagonal(self) -> tuple[Coefficient, ...]:
        """c_kk (kg m^2) alone, without the O(N^2) others."""
        return self._chain.c_diagonal

    @property
    def gravity(self) -> Coefficient:
        """g (m/s^2), as V holds it."""
        return self._chain.gravity

    @property
    def stiffness(self) -> tuple[Coefficient, ...]:
        """k_k (N m/rad), as V holds them; zeros without springs."""
        return self._chain.stiffness

    @property
    def damping(self) -> tuple[Coefficient, ...]:
        """d_k (N m s/rad), as Rayleigh's function holds them; zeros without dampers."""
        return self._chain.damping

    @property
    def armature(self) -> tuple[Coefficient, ...]:
        """A_k (kg m^2), the rotors' inertias as T holds them; zeros without rotors."""
        return self._chain.armature

    @property
    def rest_angle(self) -> tuple[Coefficient, ...]:
        """alpha_k (rad), the joints' angles at which planar springs rest; zeros along the links before."""
        return self._chain.rest_angle

    @property
    def friction(self) -> tuple[Coefficient, ...]:
        """F_k (N m) of dry friction F_k tanh(slip_k / v_0), as Rayleigh's function holds them; zeros without."""
        return self._chain.friction

    @property
    def cart_damping(self) -> Coefficient:
        """d_0 (N s/m), as Rayleigh's function holds it; zero without a damper on the cart."""
        return self._chain.cart_damping

    @property
    def cart_friction(self) -> Coefficient:
        """F_0 (N) of the cart's dry friction F_0 tanh(x' / v_0); zero without."""
        return self._chain.cart_friction

    @cached_property
    def positions(self) -> tuple[sympy.ImmutableDenseMatrix, ...]:
        """r_a (m), the positions of the masses by component, the last axis along gravity."""
        names, free = names_of(self.scene), self._chain.free
        vectors: dict[sympy.Symbol, sympy.Expr] = {
            symbol: place
            for k, direction in enumerate(self.directions, 1)
            for symbol, place in zip(names.link(k), direction, strict=True)
        }
        vectors |= zip(names.joint(0), [*self.symbols.cart] or [sympy.S.Zero] * names.axes, strict=False)
        vectors[names.joint(0)[-1]] = sympy.S.Zero
        return tuple(
            sympy.ImmutableDenseMatrix(
                [sympy.Add(*[expression(weight) * vectors[free[i]] for i, weight in form.items()]) for form in mass]
            )
            for mass in self._chain.positions
        )

    @cached_property
    def directions(self) -> tuple[tuple[sympy.Expr, ...], ...]:
        """q_k by component: (sin phi_k, cos phi_k) in the plane, symbols in space."""
        if isinstance(self._expressions, SpatialExpressions):
            return self.symbols.links
        return tuple((sympy.sin(angle), sympy.cos(angle)) for angle in self._expressions.phi)

    @property
    def kinetic(self) -> sympy.Expr:
        """T (J)."""
        return self.exact.kinetic

    @property
    def potential(self) -> sympy.Expr:
        """V (J), zero for all links horizontal and springs at rest."""
        return self.exact.potential

    @property
    def lagrangian(self) -> sympy.Expr:
        """L = T - V (J)."""
        return self.kinetic - self.potential

    @property
    def mass_matrix(self) -> sympy.ImmutableDenseMatrix:
        """I of (15), or the matrix of (16); nv x nv."""
        return self._expressions.mass_matrix

    @property
    def coriolis(self) -> sympy.ImmutableDenseMatrix:
        """N of (15), or the velocity terms of (16); nv x 1."""
        return self._expressions.coriolis

    @property
    def gravity_torque(self) -> sympy.ImmutableDenseMatrix:
        """G of (15), or the gravity terms of (16), without springs; nv x 1."""
        return self._expressions.gravity_torque

    @property
    def joint_torque(self) -> sympy.ImmutableDenseMatrix:
        """The terms of springs, dampers and dry friction on the left side of the equations, the cart's in its rows; nv x 1."""
        return self._expressions.joint_torque

    @property
    def equations(self) -> tuple[sympy.Eq, ...]:
        """The equations of motion, (15) or (16): one Eq per entry of v."""
        return self._expressions.equations

    @property
    def unit_vector_equations(self) -> tuple[sympy.Eq, ...]:
        """Paper B's (15), the spatial equations in q_k'' instead of omega_k'.

        Raises:
            UnsupportedError: The scene is planar.
        """
        if isinstance(self._expressions, SpatialExpressions):
            return self._expressions.unit_vector_equations
        raise UnsupportedError("space", "planar", "has no equations in unit vectors", "read model.equations")

    def latex(self) -> str:
        """Return T, V and the equations of motion as one LaTeX aligned block."""
        return display.latex(self)

    def __str__(self) -> str:
        return display.text(self)

    def _repr_latex_(self) -> str:
        return f"$\\displaystyle {self.latex()}$"

    @cached_property
    def _chain(self) -> Coefficients:
        return Coefficients(self.scene, self.energies)

    @cached_property
    def _expressions(self) -> PlanarExpressions | SpatialExpressions:
        return self._written(expression)

    @cached_property
    def exact(self) -> PlanarExpressions | SpatialExpressions:
        """T, V and the equations with exact numbers, where the other expressions show some as decimals."""
        return self._written(exact)

    def _written(self, show: Show) -> PlanarExpressions | SpatialExpressions:
        kind = PlanarExpressions if self.scene.is_planar else SpatialExpressions
        return kind(self._chain, self.symbols, show)


def derive(scene: Scene) -> Model:
    """Return the mechanics of a scene: Lagrangian, exact coefficients, equations (docs/theory.md, sections 1 to 4).

    Raises:
        SceneError: What is given is no `Scene`.
    """
    scene = given_scene(scene)
    return Model(scene, energies_of(scene))


def with_symbols(scene: Scene) -> Scene:
    """Return the same chain with every parameter it has as a runtime symbol, to read its formulas.

    Masses at the links' ends stay there, and absent joints stay absent.
    """
    present: dict[str, Any] = {name: "runtime" for name in PARAMETERS if getattr(scene, name) is not None}
    return replace(scene, **present)

