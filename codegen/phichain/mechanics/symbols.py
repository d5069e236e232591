"""The SymPy symbols of a scene, and the exact value or symbol that stands for each of its parameters.

Names read as the papers print them, in text and in LaTeX: theta_1, thetadot_1, thetaddot_1; x, q_1_1,
omega_1_1; the parameters m_k, l_k, r_k, m_0, g, d_k (dampers), k_k (springs), alpha_k (where springs rest), F_k (dry friction), d_0 and F_0
of the cart; the inputs F (force), b (acceleration of the base) and T_k (torques); c_i, the velocity of a moving base.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import Any

import sympy

from phichain.scene import Scene

Coefficient = Any
"""A Fraction, or a SymPy expression where runtime parameters take part."""

Show = Callable[[Coefficient], sympy.Expr]
"""How a coefficient becomes an expression: `exact`, or `expression` as it is read."""

Symbols = tuple[sympy.Symbol, ...]

_LETTERS = {
    "mass": "m",
    "length": "l",
    "com": "r",
    "damping": "d",
    "stiffness": "k",
    "inertia": "J",
    "armature": "A",
    "friction": "F",
    "rest_angle": "alpha",
}
_LONGEST_RATIONAL = 10_000


@dataclass(frozen=True)
class ChainSymbols:
    """The symbols of a scene's coordinates, inputs and parameters, in the order of the contract's vectors.

    Planar: q = [x, theta_k], v and a its rates. Spatial: q = [x_1, x_2, q_k], v = [x', omega_k], a = [x'',
    omega_k'].
    """

    scene: Scene

    @cached_property
    def cart(self) -> Symbols:
        """The cart's coordinates: x, or x_1 and x_2."""
        return self._cart("x")

    @cached_property
    def cart_rate(self) -> Symbols:
        """x'."""
        return self._cart("xdot")

    @cached_property
    def cart_acceleration(self) -> Symbols:
        """x''."""
        return self._cart("xddot")

    @property
    def base_rate(self) -> Symbols:
        """The components of p_0' that there are (m/s): x' of a cart, those of a moving base along the axes that it is told."""
        return self._moving("c") if self.scene.is_moving else self.cart_rate

    @property
    def base_axes(self) -> tuple[int, ...]:
        """Which components of p_0' these are, counted from 0."""
        return self.scene.told_axes if self.scene.is_moving else tuple(range(len(self.cart_rate)))

    def along_base(self, components: Sequence[sympy.Expr]) -> tuple[sympy.Expr, ...]:
        """A vector of all axes by its components along those of the base; zero along others."""
        given = dict(zip(self.base_axes, components, strict=True))
        return tuple(given.get(axis, sympy.S.Zero) for axis in range(self.scene.dimensions))

    @property
    def base_acceleration(self) -> Symbols:
        """The components of p_0'' (m/s^2), where they are inputs."""
        return self._moving("b") if self.scene.is_moving else self._cart("b") if self.scene.is_driven else ()

    @cached_property
    def theta(self) -> Symbols:
        """The scene's planar angles (rad)."""
        return self._links("theta")

    @cached_property
    def theta_dot(self) -> Symbols:
        """Their rates (rad/s)."""
        return self._links("thetadot")

    @cached_property
    def theta_ddot(self) -> Symbols:
        """Their accelerations (rad/s^2)."""
        return self._links("thetaddot")

    @cached_property
    def links(self) -> tuple[Symbols, ...]:
        """The unit vectors q_k of a spatial scene, by component."""
        return self._vectors("q")

    @cached_property
    def link_rates(self) -> tuple[Symbols, ...]:
        """q_k', by component (1/s)."""
        return self._vectors("qdot")

    @cached_property
    def link_accelerations(self) -> tuple[Symbols, ...]:
        """q_k'', by component (1/s^2)."""
        return self._vectors("qddot")

    @cached_property
    def omega(self) -> tuple[Symbols, ...]:
        """The angular velocities omega_k, by component (rad/s)."""
        return self._vectors("omega")

    @cached_property
    def omega_dot(self) -> tuple[Symbols, ...]:
        """Their rates (rad/s^2)."""
        return self._vectors("omegadot")

    @cached_property
    def force(self) -> Symbols:
        """The horizontal force on the cart (N), if the scene has one."""
        return self._cart("F") if self.scene.has_force and not self.scene.is_driven else ()

    @cached_property
    def torque(self) -> Symbols:
        """The generalised forces of the actuated angles (N m)."""
        return tuple(sympy.Symbol(f"T_{joint}") for joint in self.scene.actuated_joints)

    @property
    def q(self) -> Symbols:
        """The configuration in the contract's order."""
        return self.cart + (self.theta if self.scene.is_planar else sum(self.links, ()))

    @property
    def v(self) -> Symbols:
        """The velocities in the contract's order."""
        return self.cart_rate + (self.theta_dot if self.scene.is_planar else sum(self.omega, ()))

    @property
    def a(self) -> Symbols:
        """The accelerations in the contract's order."""
        return self.cart_acceleration + (self.theta_ddot if self.scene.is_planar else sum(self.omega_dot, ()))

    @property
    def u(self) -> Symbols:
        """The inputs in the contract's order."""
        return self.base_acceleration + self.force + self.torque

    def _cart(self, name: str) -> Symbols:
        if not self.scene.has_cart:
            return ()
        return (sympy.Symbol(name),) if self.scene.is_planar else sympy.symbols(f"{name}_1 {name}_2")

    def _moving(self, name: str) -> Symbols:
        return tuple(sympy.Symbol(f"{name}_{axis + 1}") for axis in self.scene.told_axes)

    def _links(self, name: str) -> Symbols:
        return tuple(sympy.Symbol(f"{name}_{k}") for k in range(1, self.scene.links + 1))

    def _vectors(self, name: str) -> tuple[Symbols, ...]:
        links = range(1, self.scene.links + 1)
        return tuple(tuple(sympy.Symbol(f"{name}_{k}_{i}") for i in (1, 2, 3)) for k in links)


def parameter(scene: Scene, name: str) -> tuple[Coefficient, ...]:
    """Return a per-link parameter as exact fractions of its binary64 values, or as symbols if it is runtime.

    Absent joints are zeros; `com` of masses at the links' ends is `length`.
    """
    value: Any = getattr(scene, name)
    if value is None:
        return parameter(scene, "length") if name == "com" else (Fraction(0),) * scene.links
    if isinstance(value, str):
        letter, is_positive = _LETTERS[name], True if name != "rest_angle" else None
        return tuple(sympy.Symbol(f"{letter}_{k}", positive=is_positive) for k in range(1, scene.links + 1))
    return tuple(Fraction(entry) for entry in value)


_OF_CART = {"cart_damping": "d_0", "cart_friction": "F_0"}


def cart_law(scene: Scene, name: str) -> Coefficient:
    """Return `cart_damping`, d_0 (N s/m), or `cart_friction`, F_0 (N); zero where there is none."""
    value: Any = getattr(scene, name)
    return sympy.Symbol(_OF_CART[name], positive=True) if isinstance(value, str) else Fraction(value or 0)


def single(scene: Scene, name: str) -> Coefficient:
    """Return a parameter of the whole chain by its name."""
    return {"cart_mass": cart_mass, "gravity": gravity}[name](scene) if name not in _OF_CART else cart_law(scene, name)


def cart_mass(scene: Scene) -> Coefficient:
    """Return m_0 (kg), zero on a fixed base."""
    if isinstance(scene.cart_mass, str):
        return sympy.Symbol("m_0", positive=True)
    return Fraction(scene.cart_mass or 0)


def gravity(scene: Scene) -> Coefficient:
    """Return g (m/s^2); a runtime one is taken to pull downwards."""
    return sympy.Symbol("g", positive=True) if isinstance(scene.gravity, str) else Fraction(scene.gravity)


def exact(value: Coefficient) -> sympy.Expr:
    """Return a coefficient as SymPy calculates with it, without rounding."""
    return sympy.Rational(value.numerator, value.denominator) if isinstance(value, Fraction) else sympy.sympify(value)


def number(value: sympy.Expr) -> Coefficient:
    """Return a SymPy expression as a coefficient: a Fraction if it is a rational number."""
    return Fraction(int(value.p), int(value.q)) if value.is_Rational else value


def expression(value: Any) -> sympy.Expr:
    """Return a coefficient as SymPy prints it well: short fractions exactly, others as decimals."""
    if isinstance(value, Fraction):
        return _short(exact(value))
    whole = sympy.sympify(value)
    return whole.xreplace({entry: _short(entry) for entry in whole.atoms(sympy.Rational)})


def _short(value: sympy.Rational) -> sympy.Expr:
    return value if value.q <= _LONGEST_RATIONAL else sympy.Float(value)
