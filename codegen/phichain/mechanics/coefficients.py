"""The coefficients of a Lagrangian, read off its expressions: mu_k, c_ij, M00, g, what joints hold and what brakes the cart.

With the definitions eliminated down to the rates of the base and of the links, T is a quadratic form in them and S a linear
one in their places:

    T = 1/2 M00 |p_0'|^2 + p_0'.sum_k mu_k q_k' + 1/2 sum_ij c_ij q_i'.q_j',    V = -g S + springs,    S = sum_k mu_k e_d.q_k,

and what rotors at the joints add to T.

The coefficients are those of the first component; that all of T and V is made of them is for `lowering` to check. Terms of
equal weight are gathered before they are multiplied, so a coefficient comes out as (sum of masses) times lever times lever,
and values are exact: fractions, or SymPy expressions where runtime parameters take part.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass
from fractions import Fraction
from functools import cache, cached_property
from itertools import chain
from math import lcm, prod

import sympy

from phichain.mechanics.energies import Energies, Names, names_of
from phichain.mechanics.symbols import ChainSymbols, Coefficient, number
from phichain.scene import Scene

Form = Mapping[int, Coefficient]
"""A linear form: the weight of every place or rate at which elimination ends, by its number in `Coefficients.free`."""

Monomial = tuple[Coefficient, tuple[sympy.Symbol, ...]]


@dataclass(frozen=True)
class Coefficients:
    """What the Lagrangian of a chain holds, each made when first asked for."""

    scene: Scene
    energies: Energies

    @cached_property
    def mu(self) -> tuple[Coefficient, ...]:
        """mu_k (kg m), the coefficients of e_d.q_k in S."""
        found = self._linear(dict(self.energies.definitions).get(self._names.moment, sympy.S.Zero))
        return tuple(found.get(self._number[self._names.link(k)[-1]], Fraction(0)) for k in self._links)

    @cached_property
    def coupling(self) -> tuple[Coefficient, ...]:
        """The coefficients of p_0'.q_k' in T (kg m), empty on a fixed base; they come out equal to mu_k."""
        return () if self.scene.base_law.rests else tuple(self._moment(0, k) for k in self._links)

    @cached_property
    def c(self) -> tuple[tuple[Coefficient, ...], ...]:
        """c_ij (kg m^2), the coefficients of q_i'.q_j' in 2 T, a symmetric N x N table."""
        lower = {(i, j): self._moment(i, j) for j in self._links for i in range(1, j)}
        lower |= {(k, k): entry for k, entry in enumerate(self.c_diagonal, 1)}
        return tuple(tuple(lower[min(i, j), max(i, j)] for j in self._links) for i in self._links)

    @cached_property
    def c_diagonal(self) -> tuple[Coefficient, ...]:
        """c_kk (kg m^2) alone, in O(N^2)."""
        return tuple(self._moment(k, k) for k in self._links)

    @cached_property
    def total_mass(self) -> Coefficient:
        """M00 (kg), the coefficient of |p_0'|^2 in 2 T: the mass of the chain, and of the cart if there is one."""
        return self._moment(0, 0)

    @cached_property
    def gravity(self) -> Coefficient:
        """g (m/s^2), the coefficient of -S in V."""
        return -_sums(self._terms(self.energies.potential)).get((self._names.moment,), Fraction(0))

    @cached_property
    def stiffness(self) -> tuple[Coefficient, ...]:
        """k_k (N m/rad): V holds 1/2 k_k bend_k^2 in the plane, k_k bend_k in space."""
        found, power = _sums(self._terms(self.energies.potential)), 2 if self.scene.is_planar else 1
        return tuple(power * found.get((self._names.bend(k),) * power, Fraction(0)) for k in self._links)

    @cached_property
    def damping(self) -> tuple[Coefficient, ...]:
        """d_k (N m s/rad): R holds 1/2 d_k |slip_k|^2."""
        return tuple(2 * self._losses.get((self._names.slip(k)[0],) * 2, Fraction(0)) for k in self._links)

    @cached_property
    def friction(self) -> tuple[Coefficient, ...]:
        """F_k (N m): R holds F_k v_0 ln cosh(slip_k / v_0); zeros without dry friction."""
        return tuple(self._rubbed(k, self.scene.friction_speed) for k in self._links)

    @cached_property
    def cart_damping(self) -> Coefficient:
        """d_0 (N s/m): R holds 1/2 d_0 |p_0'|^2."""
        rate = self._names.joint(0, rate=True)[0]
        return 2 * self._losses.get((rate, rate), Fraction(0))

    @cached_property
    def cart_friction(self) -> Coefficient:
        """F_0 (N): R holds F_0 v_0 ln cosh(x' / v_0)."""
        return self._rubbed(0, self.scene.cart_friction_speed)

    @cached_property
    def rest_angle(self) -> tuple[Coefficient, ...]:
        """alpha_k (rad), where planar springs rest: what is missing from phi_k - phi_{k-1} in bend_k."""
        bends = dict(self.energies.definitions)
        found = [_sums(self._terms(bends.get(self._names.bend(k), sympy.S.Zero))) for k in self._links]
        return tuple(-terms.get((), Fraction(0)) if self.scene.is_planar else Fraction(0) for terms in found)

    @cached_property
    def _losses(self) -> dict[tuple[sympy.Symbol, ...], Coefficient]:
        return _sums(self._terms(self.energies.dissipation))

    def _rubbed(self, k: int, speed: float | None) -> Coefficient:
        return self._losses.get((self._names.rub(k),), Fraction(0)) / Fraction(speed or 1)

    @cached_property
    def armature(self) -> tuple[Coefficient, ...]:
        """A_k (kg m^2): T holds 1/2 A_k slip_k^2."""
        found = _sums(self._terms(self.energies.kinetic))
        return tuple(2 * found.get((self._names.slip(k)[0],) * 2, Fraction(0)) for k in self._links)

    @cached_property
    def positions(self) -> tuple[tuple[Form, ...], ...]:
        """r_k by component, as linear forms in the base's place and the links."""
        return tuple(tuple(self._forms.get(y, {}) for y in self._names.mass(k)) for k in self._links)

    @property
    def _names(self) -> Names:
        return names_of(self.scene)

    @property
    def _links(self) -> range:
        return range(1, self.scene.links + 1)

    @cached_property
    def free(self) -> tuple[sympy.Symbol, ...]:
        """Where elimination ends: the base's place and the links, and their rates."""
        names = self._names
        vectors = [names.link(k, rate) for rate in (False, True) for k in self._links]
        return tuple(chain.from_iterable((*vectors, names.joint(0), names.joint(0, rate=True))))

    @cached_property
    def _number(self) -> dict[sympy.Symbol, int]:
        """The number of each of them; the cart's place and rate are those of the base, and so is the rate that is given."""
        numbers, symbols = {symbol: i for i, symbol in enumerate(self.free)}, ChainSymbols(self.scene)
        for own, rate in ((symbols.cart, False), (symbols.base_rate, True)):
            places = [self._names.joint(0, rate)[axis] for axis in symbols.base_axes]
            numbers |= {symbol: numbers[base] for symbol, base in zip(own, places, strict=False)}
        return numbers

    @cached_property
    def _variables(self) -> frozenset[sympy.Symbol]:
        return frozenset((*self._number, *(symbol for symbol, _ in self.energies.definitions)))

    @cached_property
    def _forms(self) -> dict[sympy.Symbol, Form]:
        """Every definition that is linear, eliminated."""
        known: dict[sympy.Symbol, Form] = {symbol: {i: Fraction(1)} for symbol, i in self._number.items()}
        for symbol, expression in self.energies.definitions:
            terms = list(self._terms(expression)) if symbol not in known else []
            if terms and all(len(factors) == 1 and factors[0] in known for _, factors in terms):
                known[symbol] = _combined([(weight, known[factor]) for weight, (factor,) in terms])
        return known

    def _linear(self, expression: sympy.Expr) -> Form:
        linear: list[tuple[Coefficient, Form]]
        linear = [(weight, self._forms[f[0]]) for weight, f in self._terms(expression) if len(f) == 1 and f[0] in self._forms]
        return _combined(linear) if linear else {}

    def _terms(self, expression: sympy.Expr) -> Iterator[Monomial]:
        return _monomials(expression, self._variables)

    def _moment(self, i: int, j: int) -> Coefficient:
        """The coefficient of the rates of two vectors in 2 T, 0 for the base, by their first components."""
        groups: dict[tuple[object, object], tuple[Coefficient, Coefficient, list[int]]] = {}
        inner, outer = sorted((self._columns[i], self._columns[j]), key=len)
        for (term, own, other), weight in inner.items():
            if (term, other, own) in outer:
                facing = outer[term, other, own]
                groups.setdefault((_key(weight), _key(facing)), (weight, facing, []))[2].append(term)
        return total(prod(levers, start=self._mass(tuple(terms))) for *levers, terms in groups.values())

    @cached_property
    def _squares(self) -> list[Monomial]:
        """The terms of 2 T, each a product of two rates."""
        return [(2 * weight, factors) for weight, factors in self._terms(self.energies.kinetic) if len(factors) == 2]

    @cached_property
    def _columns(self) -> list[dict[tuple[int, int, int], Coefficient]]:
        """For the base and every link: its weight in each factor of each product of rates; `_moment` pairs factors crosswise."""
        names = self._names
        place = {self._number[names.joint(0, rate=True)[0]]: 0}
        place |= {self._number[names.link(k, rate=True)[0]]: k for k in self._links}
        columns: list[dict[tuple[int, int, int], Coefficient]] = [{} for _ in range(self.scene.links + 1)]
        for term, (_, (first, second)) in enumerate(self._squares):
            pairs = ((first, 0, 0),) if first == second else ((first, 0, 1), (second, 1, 0))
            for factor, own, other in pairs:
                for free, weight in self._forms.get(factor, {}).items():
                    if free in place:
                        columns[place[free]][term, own, other] = weight
        return columns

    @cached_property
    def _mass(self) -> Callable[[tuple[int, ...]], Coefficient]:
        """The sum of the coefficients of some products of rates; few sums occur, each often. A mixed product counts half."""

        @cache
        def mass(terms: tuple[int, ...]) -> Coefficient:
            products = (self._squares[term] for term in terms)
            return total(weight if first == second else weight / 2 for weight, (first, second) in products)

        return mass


def total(terms: Iterable[Coefficient]) -> Coefficient:
    """Return the sum of coefficients: a Fraction if all are, one SymPy Add otherwise."""
    known = list(terms)
    if all(isinstance(term, Fraction) for term in known):
        denominator = lcm(*(term.denominator for term in known))
        return Fraction(sum(term.numerator * (denominator // term.denominator) for term in known), denominator)
    return sympy.Add(*map(sympy.sympify, known))


def _combined(terms: Sequence[tuple[Coefficient, Form]]) -> Form:
    """A sum of weighted linear forms, equal weights gathered."""
    found: dict[int, dict[object, tuple[Coefficient, list[Coefficient]]]] = {}
    (first, start), *others = terms
    if first == 1 and all(len(form) == 1 and not form.keys() & start.keys() for _, form in others):
        longer = dict(start)  # a joint's place and one link more: not worth gathering
        for factor, form in others:
            for free, weight in form.items():
                longer[free] = factor * weight
        return longer
    for factor, form in terms:
        for free, weight in form.items():
            found.setdefault(free, {}).setdefault(_key(weight), (weight, []))[1].append(factor)
    return {
        free: total(weight if factors == [1] else total(factors) * weight for weight, factors in groups.values())
        for free, groups in found.items()
    }


def _key(weight: Coefficient) -> object:
    """What equal weights share: symbols compare fast; numbers do not, and what is handed on is one object."""
    return id(weight) if isinstance(weight, Fraction) else weight


def _sums(terms: Iterable[Monomial]) -> dict[tuple[sympy.Symbol, ...], Coefficient]:
    """The coefficient of every product of symbols."""
    found: dict[tuple[sympy.Symbol, ...], list[Coefficient]] = {}
    for weight, factors in terms:
        found.setdefault(factors, []).append(weight)
    return {factors: total(weights) for factors, weights in found.items()}


def _monomials(expression: sympy.Expr, variables: AbstractSet[sympy.Symbol]) -> Iterator[Monomial]:
    """The terms of a polynomial: coefficient, and the variables in it; what is no polynomial counts as a coefficient."""
    for term in sympy.Add.make_args(expression):
        weight: list[sympy.Expr] = []
        factors: list[sympy.Symbol] = []
        for factor in sympy.Mul.make_args(term):
            base, power = factor.as_base_exp()
            if base in variables and power.is_Integer and power > 0:
                factors += [base] * int(power)
            else:
                weight.append(factor)
        mixed = any(factor.has(sympy.Add) and factor.free_symbols & variables for factor in weight)
        if mixed and (expanded := sympy.expand(term)) != term:
            yield from _monomials(expanded, variables)
        else:
            yield number(sympy.Mul(*weight)), tuple(factors)
