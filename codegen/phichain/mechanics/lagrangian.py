"""The Lagrangian as it is defined: T, V and the joints' dissipation from the positions of the masses, in O(N) symbols.

`Model.kinetic` and `Model.potential` show T and V with their coefficients collected, a term for every pair of links. Here each
quantity on the way stands as a symbol with its definition, in the order in which they build on each other (theory section 1):

    q_k = (sin phi_k, cos phi_k) in the plane,    b_k = b_{k-1} + l_k q_k,    r_k = b_{k-1} + r_k q_k,    b_0 = C x
    T = 1/2 m_0 |x'|^2 + sum_k 1/2 m_k |r_k'|^2,    V = -g sum_k m_k e_d.r_k + springs
    springs: 1/2 k_k (phi_k - phi_{k-1})^2, in space k_k (1 - q_{k-1}.q_k);    R = sum_k 1/2 d_k |rate_k - rate_{k-1}|^2

so that a long chain is as cheap to derive, to differentiate and to evaluate exactly as its Programs are.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import count

import sympy

from phichain.mechanics.coordinates import absolute_angles
from phichain.mechanics.symbols import ChainSymbols
from phichain.scene import Scene

Expressions = tuple[sympy.Expr, ...]


@dataclass(frozen=True)
class Lagrangian:
    """T, V and R of one chain, in the symbols of its coordinates, rates, parameters and definitions.

    In space T and V are functions of q_k and q_k', R is one of omega_k.

    Attributes:
        definitions: every further symbol with its expression, in order.
        positions: r_k of every mass by component, m, the last one along gravity.
        kinetic: T, J.
        weight: the part of V that is gravity's, J.
        springs: the part of V that is the springs', J.
        dissipation: R, W: dampers act with -dR/drate.
    """

    definitions: tuple[tuple[sympy.Symbol, sympy.Expr], ...]
    positions: tuple[Expressions, ...]
    kinetic: sympy.Expr
    weight: sympy.Expr
    springs: sympy.Expr
    dissipation: sympy.Expr


@dataclass(frozen=True)
class ParameterSymbols:
    """The symbols of all parameters, whether the scene has numbers for them or not.

    Attributes:
        mass: m_k, kg.
        length: l_k, m.
        com: r_k, m; l_k where masses are at the links' ends.
        damping: d_k, N m s/rad; empty without dampers.
        stiffness: k_k, N m/rad; empty without springs.
        cart_mass: m_0, kg.
        gravity: g, m/s^2.
    """

    mass: Expressions
    length: Expressions
    com: Expressions
    damping: Expressions
    stiffness: Expressions
    cart_mass: sympy.Expr
    gravity: sympy.Expr

    @classmethod
    def of(cls, scene: Scene) -> ParameterSymbols:
        """The symbols of a scene."""

        def each(letter: str) -> Expressions:
            return tuple(sympy.Symbol(f"{letter}_{k}", positive=True) for k in range(1, scene.links + 1))

        return cls(
            mass=each("m"),
            length=each("l"),
            com=each("l") if scene.com is None else each("r"),
            damping=() if scene.damping is None else each("d"),
            stiffness=() if scene.stiffness is None else each("k"),
            cart_mass=sympy.Symbol("m_0", positive=True),
            gravity=sympy.Symbol("g", positive=True),
        )


class _Definitions:
    """Names quantities one after the other."""

    def __init__(self) -> None:
        self.known: list[tuple[sympy.Symbol, sympy.Expr]] = []
        self._numbers = count(1)

    def name(self, value: sympy.Expr) -> sympy.Expr:
        """The value as a symbol, unless it is one or a number already."""
        if value.is_Symbol or value.is_Number:
            return value
        symbol = sympy.Symbol(f"y_{next(self._numbers)}")
        self.known.append((symbol, value))
        return symbol

    def all(self, values: Sequence[sympy.Expr]) -> Expressions:
        """The same of several."""
        return tuple(self.name(value) for value in values)


def define(scene: Scene, symbols: ChainSymbols) -> Lagrangian:
    """Write T, V and R of a chain from the positions of its masses."""
    named, parameters = _Definitions(), ParameterSymbols.of(scene)
    links = tuple(_planar_links(scene, symbols, named) if scene.is_planar else _spatial_links(symbols))
    size = len(links[0][0])
    base, speed = ((*cart, *[sympy.S.Zero] * (size - len(cart))) for cart in (symbols.cart, symbols.cart_rate))
    positions, kinetic, weight = [], [parameters.cart_mass * entry**2 / 2 for entry in symbols.cart_rate], []
    for k, (link, rate) in enumerate(links):
        mass, length, com = parameters.mass[k], parameters.length[k], parameters.com[k]
        place, motion = named.all(_along(base, com, link)), named.all(_along(speed, com, rate))
        positions.append(place)
        kinetic.append(mass * sympy.Add(*[entry**2 for entry in motion]) / 2)
        weight.append(-parameters.gravity * mass * place[-1])
        base, speed = named.all(_along(base, length, link)), named.all(_along(speed, length, rate))
    springs, dissipation = (_planar_joints if scene.is_planar else _spatial_joints)(scene, symbols, parameters, named)
    return Lagrangian(
        tuple(named.known), tuple(positions), sympy.Add(*kinetic), sympy.Add(*weight), springs, dissipation
    )


def _along(start: Sequence[sympy.Expr], weight: sympy.Expr, vector: Sequence[sympy.Expr]) -> list[sympy.Expr]:
    return [a + weight * b for a, b in zip(start, vector, strict=True)]


def _planar_links(
    scene: Scene, symbols: ChainSymbols, named: _Definitions
) -> Iterator[tuple[Expressions, Expressions]]:
    """q_k and q_k' of a planar chain, by component."""
    for angle, rate in zip(*_turns(scene, symbols, named), strict=True):
        sine, cosine = named.all((sympy.sin(angle), sympy.cos(angle)))
        yield (sine, cosine), named.all((cosine * rate, -sine * rate))


def _turns(scene: Scene, symbols: ChainSymbols, named: _Definitions) -> tuple[Expressions, Expressions]:
    """phi_k and phi_k', a sum of two symbols each, named anew where they are asked for."""
    if scene.angles == "relative":
        sums: list[Expressions] = []
        for entries in (symbols.theta, symbols.theta_dot):
            total, found = sympy.S.Zero, []
            for entry in entries:
                total = named.name(total + entry)
                found.append(total)
            sums.append(tuple(found))
        return sums[0], sums[1]
    angles = str(scene.angles)
    return named.all(absolute_angles(angles, symbols.theta)), named.all(absolute_angles(angles, symbols.theta_dot))


def _spatial_links(symbols: ChainSymbols) -> Iterator[tuple[Expressions, Expressions]]:
    """q_k and q_k' of a spatial chain, by component."""
    yield from zip(symbols.links, symbols.link_rates, strict=True)


def _planar_joints(
    scene: Scene, symbols: ChainSymbols, parameters: ParameterSymbols, named: _Definitions
) -> tuple[sympy.Expr, sympy.Expr]:
    """The energy of the springs and the dissipation of the dampers of a planar chain."""
    if not parameters.stiffness and not parameters.damping:
        return sympy.S.Zero, sympy.S.Zero
    angles, rates = _turns(scene, symbols, named)
    stored, lost = (
        [
            weight * named.name(outer - inner) ** 2 / 2
            for weight, inner, outer in zip(weights, (sympy.S.Zero, *turns), turns, strict=False)
        ]
        for weights, turns in ((parameters.stiffness, angles), (parameters.damping, rates))
    )
    return sympy.Add(*stored), sympy.Add(*lost)


def _spatial_joints(
    scene: Scene, symbols: ChainSymbols, parameters: ParameterSymbols, named: _Definitions
) -> tuple[sympy.Expr, sympy.Expr]:
    """The same of a spatial chain."""
    down, still = (sympy.S.Zero, sympy.S.Zero, sympy.S.One), (sympy.S.Zero,) * 3
    stored = [
        weight * (1 - sympy.Add(*[a * b for a, b in zip(inner, outer, strict=True)]))
        for weight, inner, outer in zip(parameters.stiffness, (down, *symbols.links), symbols.links, strict=False)
    ]
    lost = [
        weight * sympy.Add(*[(b - a) ** 2 for a, b in zip(inner, outer, strict=True)]) / 2
        for weight, inner, outer in zip(parameters.damping, (still, *symbols.omega), symbols.omega, strict=False)
    ]
    return sympy.Add(*stored), sympy.Add(*lost)
