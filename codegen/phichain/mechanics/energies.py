"""The Lagrangian of a chain as it follows from the positions of its masses: T, V and Rayleigh's function, with definitions.

Joint k ends link k and mass k sits on it, so that (theory section 1)

    p_0 = C x,    p_k = p_{k-1} + l_k q_k,    r_k = p_{k-1} + r_k q_k,    or p_0' = c(t) given on a moving base,

    T = 1/2 m_0 |p_0'|^2 + 1/2 sum_k (m_k |r_k'|^2 + J_k |q_k'|^2),    V = -g S + springs,    S = sum_k m_k e_d.r_k,

dampers dissipate 2 R = d_0 |x'|^2 + sum_k d_k |slip_k|^2, and in the plane the rotors of the joints' motors add
1/2 sum_k A_k slip_k^2 to T, slip_k the relative rate of joint k. Dry friction, F tanh(v / v_0) against the rate v, is the
derivative of F v_0 ln cosh(v / v_0), so that

    R = 1/2 d_0 |x'|^2 + 1/2 sum_k d_k |slip_k|^2 + F_0 v_0 ln cosh(x' / v_0) + sum_k F_k v_0 ln cosh(slip_k / v_0)

(in space of the root of |x'|^2 / v_0^2 or |slip_k|^2 / v_0^2 plus 2^-126, which keeps the root's derivative at rest)
gives all forces that take energy as its derivatives by rates; of dry friction it is no power any more, which is force times rate.
Planar springs pull towards theta_k = alpha_k, bend_k = theta_k - alpha_k. Places are counted from where a moving base is; its motion is no
coordinate, and its c is that of any inertial frame: the equations hold b = c' alone. Nothing is multiplied out: every p_k, r_k and their rates is a symbol with
a definition, so a chain of N links takes O(N) operations. In the plane q_k = (sin phi_k, cos phi_k) and phi_k is defined by
the scene's own angles; in space q_k, q_k' and omega_k are the symbols themselves. Numbers are exact rationals.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

import sympy

from phichain.contract.chain import LEAST_SQUARE
from phichain.mechanics.symbols import (
    ChainSymbols,
    Coefficient,
    cart_law,
    cart_mass,
    exact,
    gravity,
    parameter,
)
from phichain.scene import Scene

Definition = tuple[sympy.Symbol, sympy.Expr]


@dataclass(frozen=True)
class Energies:
    """T, V and Rayleigh's function, in symbols that are defined one after the other.

    Attributes:
        kinetic: T (J).
        potential: V (J), zero for all links horizontal and springs at rest.
        dissipation: R (W), Rayleigh's function: its derivatives by the rates are the forces of dampers and dry friction.
        definitions: (symbol, expression) in an order in which each leans on coordinates, rates and earlier ones alone.
    """

    kinetic: sympy.Expr
    potential: sympy.Expr
    dissipation: sympy.Expr
    definitions: tuple[Definition, ...]


@dataclass(frozen=True)
class Names:
    """The symbols that a Lagrangian is written in beside coordinates and rates; links and joints count from 1, p_0 is the base.

    Attributes:
        axes: d, the components of a vector; the last is along gravity.
    """

    axes: int

    def vector(self, letter: str, k: int) -> tuple[sympy.Symbol, ...]:
        """The components of one vector."""
        return tuple(sympy.Symbol(f"{letter}_{k}_{i}") for i in range(1, self.axes + 1))

    def joint(self, k: int, rate: bool = False) -> tuple[sympy.Symbol, ...]:
        """p_k (m), the outer end of link k, or p_k'."""
        return self.vector("pdot" if rate else "p", k)

    def mass(self, k: int, rate: bool = False) -> tuple[sympy.Symbol, ...]:
        """r_k (m), the position of mass k, or r_k'."""
        return self.vector("rdot" if rate else "r", k)

    def link(self, k: int, rate: bool = False) -> tuple[sympy.Symbol, ...]:
        """q_k, the unit vector along link k, or q_k'."""
        return self.vector("qdot" if rate else "q", k)

    def slip(self, k: int) -> tuple[sympy.Symbol, ...]:
        """What damper and rotor k see (rad/s): the relative rate of their joint, a vector in space."""
        return (sympy.Symbol(f"slip_{k}"),) if self.axes == 2 else self.vector("slip", k)

    @staticmethod
    def bend(k: int) -> sympy.Symbol:
        """What spring k sees: phi_k - phi_{k-1} - alpha_k in the plane, 1 - q_{k-1}.q_k in space."""
        return sympy.Symbol(f"bend_{k}")

    @staticmethod
    def rub(k: int) -> sympy.Symbol:
        """ln cosh of what the dry friction of joint k, or for k = 0 of the cart, sees, over its speed v_0."""
        return sympy.Symbol(f"rub_{k}")

    @property
    def moment(self) -> sympy.Symbol:
        """S (kg m), the first moment of the masses along gravity."""
        return sympy.Symbol("S")


def names_of(scene: Scene) -> Names:
    """The symbols of a scene's Lagrangian."""
    return Names(2 if scene.is_planar else 3)


def energies_of(scene: Scene) -> Energies:
    """Build the Lagrangian of a scene from the positions of its masses."""
    symbols, names, links = ChainSymbols(scene), names_of(scene), range(1, scene.links + 1)
    mass, length, com = ([exact(x) for x in parameter(scene, name)] for name in ("mass", "length", "com"))
    half = [exact(x / 2) for x in parameter(scene, "mass")]
    places = _places(scene, symbols, names, length, com)
    rates = _rates(names, symbols, scene, places)
    fall = sympy.Add(*[m * names.mass(k)[-1] for k, m in zip(links, mass, strict=True)])
    moving = [h * y**2 for k, h in zip(links, half, strict=True) for y in names.mass(k, rate=True)]
    if scene.inertia is not None:
        spins = [exact(j / 2) for j in parameter(scene, "inertia")]
        moving += [h * y**2 for k, h in zip(links, spins, strict=True) for y in names.link(k, rate=True)]
    if scene.has_cart:
        moving += [exact(cart_mass(scene) / 2) * y**2 for y in names.joint(0, rate=True)[:-1]]
    moving += [exact(a / 2) * y**2 for i, a in enumerate(parameter(scene, "armature"), 1) for y in names.slip(i)]
    springs = [
        exact(k / 2) * names.bend(i) ** 2 if scene.is_planar else exact(k) * names.bend(i)
        for i, k in enumerate(parameter(scene, "stiffness"), 1)
    ]
    losses = [exact(d / 2) * y**2 for i, d in enumerate(parameter(scene, "damping"), 1) for y in names.slip(i)]
    losses += [exact(cart_law(scene, "cart_damping") / 2) * y**2 for y in names.joint(0, rate=True)[:-1]]
    losses += [exact(force * speed) * names.rub(k) for k, _, force, speed in _frictions(scene, names)]
    definitions = [*_coordinates(scene, symbols, names), *places, *rates, (names.moment, fall)]
    if scene.stiffness is not None:
        definitions += _bends(scene, names)
    if any(law is not None for law in (scene.damping, scene.friction, scene.armature)):
        definitions += _slips(scene, symbols, names)
    definitions += [(names.rub(k), sympy.log(sympy.cosh(_size(rate, v_0)))) for k, rate, _, v_0 in _frictions(scene, names)]
    return Energies(
        kinetic=sympy.Add(*moving),
        potential=sympy.Add(-exact(gravity(scene)) * names.moment, *springs),
        dissipation=sympy.Add(*losses),
        definitions=tuple(definitions),
    )


def _places(
    scene: Scene, symbols: ChainSymbols, names: Names, length: Sequence[sympy.Expr], com: Sequence[sympy.Expr]
) -> list[Definition]:
    """p_0 = C x, then r_k and p_k link by link."""
    base = [*symbols.cart] if scene.has_cart else [sympy.S.Zero] * (names.axes - 1)
    found = list(zip(names.joint(0), [*base, sympy.S.Zero], strict=True))
    for k, (own, arm) in enumerate(zip(com, length, strict=True), 1):
        inner, link = names.joint(k - 1), names.link(k)
        found += [(r, p + own * q) for r, p, q in zip(names.mass(k), inner, link, strict=True)]
        found += [(o, p + arm * q) for o, p, q in zip(names.joint(k), inner, link, strict=True)]
    return found


def _rates(names: Names, symbols: ChainSymbols, scene: Scene, places: Sequence[Definition]) -> list[Definition]:
    """The rates of all places: positions are linear in x and q_k with constant coefficients; that of a moving base is given."""
    dots = dict(zip(symbols.cart, symbols.cart_rate, strict=True))
    moved = symbols.along_base(symbols.base_rate) if scene.is_moving else ()
    given = dict(zip(names.joint(0, rate=True), moved, strict=False))
    for k in range(scene.links + 1):
        for vector in (names.joint, *((names.mass, names.link) if k else ())):
            dots |= zip(vector(k), vector(k, rate=True), strict=True)
    return [(dots[place], given.get(dots[place], expression.xreplace(dots))) for place, expression in places]


def _coordinates(scene: Scene, symbols: ChainSymbols, names: Names) -> list[Definition]:
    """Planar links in terms of the scene's angles: phi_k, phi_k', q_k, q_k' (theory section 2); none in space."""
    found: list[Definition] = []
    for angles, phi in ((symbols.theta, absolute), (symbols.theta_dot, absolute_rate)) if scene.is_planar else ():
        for k, angle in enumerate(angles, 1):
            before = {"absolute": [], "relative": [phi(k - 1)], "adjacent": [angles[k - 2]]}[str(scene.angles)]
            found.append((phi(k), sympy.Add(angle, *(before if k > 1 else ()))))
    for k in range(1, scene.links + 1) if scene.is_planar else ():
        sine, cosine = sympy.sin(absolute(k)), sympy.cos(absolute(k))
        found += zip(names.link(k), (sine, cosine), strict=True)
        found += zip(names.link(k, rate=True), (cosine * absolute_rate(k), -sine * absolute_rate(k)), strict=True)
    return found


def absolute(k: int) -> sympy.Symbol:
    """phi_k (rad), the angle of link k from the hanging vertical."""
    return sympy.Symbol(f"phi_{k}")


def absolute_rate(k: int) -> sympy.Symbol:
    """phi_k' (rad/s)."""
    return sympy.Symbol(f"phidot_{k}")


def _size(rate: Sequence[sympy.Symbol], v_0: Fraction) -> sympy.Expr:
    """v / v_0 in the plane, and what stands for |w| / v_0 in space."""
    if len(rate) == 1:
        return rate[0] / exact(v_0)
    return sympy.sqrt(exact(1 / v_0**2) * sympy.Add(*[y**2 for y in rate]) + exact(LEAST_SQUARE))


def _frictions(scene: Scene, names: Names) -> list[tuple[int, tuple[sympy.Symbol, ...], Coefficient, Fraction]]:
    """(number, rate, F, v_0) of every dry friction, 0 the cart's."""
    found: list[tuple[int, tuple[sympy.Symbol, ...], Coefficient, Fraction]] = []
    if scene.cart_friction is not None and scene.cart_friction_speed is not None:
        rate = names.joint(0, rate=True)[:-1]
        found.append((0, rate, cart_law(scene, "cart_friction"), Fraction(scene.cart_friction_speed)))
    if scene.friction is not None and scene.friction_speed is not None:
        forces = enumerate(parameter(scene, "friction"), 1)
        found += [(k, names.slip(k), force, Fraction(scene.friction_speed)) for k, force in forces]
    return found


def _bends(scene: Scene, names: Names) -> list[Definition]:
    if scene.is_planar:
        rest = [exact(angle) for angle in parameter(scene, "rest_angle")]
        return [
            (names.bend(k), absolute(k) - (absolute(k - 1) if k > 1 else 0) - rest[k - 1]) for k in range(1, scene.links + 1)
        ]
    chain = [(sympy.S.Zero, sympy.S.Zero, sympy.S.One), *(names.link(k) for k in range(1, scene.links + 1))]
    return [
        (names.bend(k), 1 - sympy.Add(*[a * b for a, b in zip(chain[k - 1], chain[k], strict=True)]))
        for k in range(1, scene.links + 1)
    ]


def _slips(scene: Scene, symbols: ChainSymbols, names: Names) -> list[Definition]:
    still: tuple[sympy.Expr, ...] = (sympy.S.Zero,) * len(names.slip(1))
    spins: list[tuple[sympy.Expr, ...]]
    spins = [(absolute_rate(k),) for k in range(1, scene.links + 1)] if scene.is_planar else list(symbols.omega)
    return [
        (slip, own - inner)
        for k, (before, spin) in enumerate(zip([still, *spins], spins, strict=False), 1)
        for slip, own, inner in zip(names.slip(k), spin, before, strict=True)
    ]
