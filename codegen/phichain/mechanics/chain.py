"""From the positions of the point masses to the coefficients of T and V, by collecting, not by knowing them.

Mass a sits at r_a = C x + sum_{k<a} l_k q_k + r_a q_a (theory section 1). Written as a linear form in the
vectors C x and q_k, with the parameters as symbols, a position is a handful of weights. T = 1/2 sum_a m_a
|r_a'|^2 + 1/2 m_0 |x'|^2 and V = -g sum_a m_a e_d.r_a then are quadratic and linear forms whose coefficients
are collected here:

    T = 1/2 M00 |x'|^2 + x'.sum_k mu_k C^T q_k' + 1/2 sum_ij c_ij q_i'.q_j',    V = -g sum_k mu_k e_d.q_k.

Terms of equal weight are gathered before they are multiplied, so a coefficient comes out as (sum of masses)
times lever times lever, and values are exact: fractions of the binary64 numbers, or SymPy symbols of runtime
parameters.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from math import prod

import sympy

from phichain.mechanics.symbols import Coefficient, cart_mass, parameter
from phichain.scene import Scene

CART = -1
"""The index of the vector C x in a position; links are counted from 0."""

Weight = tuple[str, int]
Weights = Mapping[int, Weight]


@dataclass(eq=False)
class Collected:
    """The coefficients of T and V of one chain, collected from its positions when first asked for."""

    scene: Scene

    @cached_property
    def positions(self) -> tuple[Weights, ...]:
        """The position of every mass: the weights (1 or a length, by name) of the vectors C x and q_k."""
        links = range(self.scene.links)
        coms = [("length" if self.scene.com is None else "com", k) for k in links]
        base: dict[int, Weight] = {CART: ("one", 0)} if self.scene.has_cart else {}
        return tuple(base | {k: ("length", k) for k in range(a)} | {a: coms[a]} for a in links)

    @cached_property
    def mu(self) -> tuple[Coefficient, ...]:
        """mu_k (kg m), the coefficients of -g e_d.q_k in V."""
        return tuple(self._moment(k) for k in range(self.scene.links))

    @cached_property
    def coupling(self) -> tuple[Coefficient, ...]:
        """The coefficients of x'.C^T q_k' in T (kg m), empty on a fixed base; they come out equal to mu_k."""
        return tuple(self._moment(CART, k) for k in range(self.scene.links)) if self.scene.has_cart else ()

    @cached_property
    def c(self) -> tuple[tuple[Coefficient, ...], ...]:
        """c_ij (kg m^2), the coefficients of q_i'.q_j' in 2 T, a symmetric N x N table."""
        links = range(self.scene.links)
        lower = [[self._moment(j, i) for j in range(i + 1)] for i in links]
        return tuple(tuple(lower[max(i, j)][min(i, j)] for j in links) for i in links)

    @cached_property
    def total_mass(self) -> Coefficient:
        """M00 (kg), the coefficient of |x'|^2 in 2 T: the mass of the chain and of the cart."""
        return self._mass(tuple(range(self.scene.links))) + cart_mass(self.scene)

    def _moment(self, *vectors: int) -> Coefficient:
        """Return sum_a m_a times the weights of some vectors in r_a; equal weights are gathered first."""
        groups: dict[tuple[Weight, ...], list[int]] = {}
        outermost = max(vectors)  # an outer vector moves no inner mass
        for a, position in enumerate(self.positions[outermost:], outermost):
            groups.setdefault(tuple(position[vector] for vector in vectors), []).append(a)
        return total(
            prod((self.values[name][k] for name, k in weights), start=self._mass(tuple(masses)))
            for weights, masses in groups.items()
        )

    def _mass(self, links: tuple[int, ...]) -> Coefficient:
        """Return the sum of the masses of some links; few sums occur, each often."""
        if links not in self._masses:
            self._masses[links] = total(self.values["mass"][k] for k in links)
        return self._masses[links]

    @cached_property
    def _masses(self) -> dict[tuple[int, ...], Coefficient]:
        return {}

    @cached_property
    def values(self) -> dict[str, tuple[Coefficient, ...]]:
        """The exact value or symbol of every weight and mass, by the name it has in `positions`."""
        known = {name: parameter(self.scene, name) for name in ("mass", "length", "com")}
        return known | {"one": (Fraction(1),)}


def total(terms: Iterable[Coefficient]) -> Coefficient:
    """Return the sum of coefficients: a Fraction if all are, one SymPy Add otherwise."""
    known = list(terms)
    if all(isinstance(term, Fraction) for term in known):
        return sum(known, Fraction(0))
    return sympy.Add(*map(sympy.sympify, known))
