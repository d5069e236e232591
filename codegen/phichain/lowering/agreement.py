"""Whether a Model's Lagrangian is the one that the Programs' forms serve, exactly.

The structured forms use masses and lengths one by one; others use mu_k, c_kk and M00 with c_ij = l_i mu_j for i < j. All of
them solve one Lagrangian,

    T = 1/2 M00 |x'|^2 + x'.sum_k mu_k C^T q_k' + 1/2 sum_k c_kk |q_k'|^2 + sum_{i<j} l_i mu_j q_i'.q_j',
    V = -g sum_k mu_k e_d.q_k + springs,    2 R = d_0 |x'|^2 + sum_k d_k |slip_k|^2 + dry friction,

and T = 1/2 m_0 |x'|^2 + 1/2 sum_k (m_k |r_k'|^2 + J_k |q_k'|^2) of the same numbers; rotors add 1/2 A_k slip_k^2 to either. Both,
with the numbers as Programs hold them or compute them, are compared with the Model's T, V and R at random points modulo a prime: any
term that is missing, wrong or one too many shows, for O(N) operations a point. Which coefficient it is, is found out only then.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Iterator, Mapping, Sequence
from fractions import Fraction
from itertools import pairwise
from random import Random
from typing import Any, Final
from weakref import WeakValueDictionary

import sympy

from phichain.contract.chain import LEAST_SQUARE
from phichain.errors import DerivationError
from phichain.ir.builder import Builder
from phichain.ir.interpret import Algebra, run
from phichain.ir.nodes import Program
from phichain.ir.passes import prune
from phichain.lowering.chain.parameters import Parameters
from phichain.mechanics import Model
from phichain.mechanics.coordinates import absolute_angles
from phichain.mechanics.energies import names_of
from phichain.mechanics.residues import PRIME, Residues, inverse
from phichain.mechanics.symbols import Coefficient, exact, parameter, single
from phichain.scene.keys import PER_LINK

#: A wrong coefficient passes one point with a probability below 1e-17.
_POINTS: Final = 3
#: Up to so many links T and V as they are written out, O(N^2) terms, are compared, too.
_WRITTEN_OUT: Final = 8
_REMEDY: Final = "derive the model with phichain.derive, or mend its Lagrangian: no form of phichain solves this one"

Values = Mapping[str, Sequence[Any]]


def check_model(model: Model) -> None:
    """Compare T, V and R of a Model with what the Programs compute with.

    Raises:
        DerivationError: What is given is no Model, or they differ; it names the coefficient and both its values.
    """
    if not isinstance(model, Model):
        raise DerivationError("model", model, "is not a Model", "write lower(derive(scene))")
    if _AGREED.get(id(model)) is model:
        return
    points = [_point(model, number) for number in range(_POINTS)]
    program = _coefficients(model)
    for point in points:
        given = {name: [point.value(entry) for entry in values] for name, values in _symbols(model).items()}
        held = run(program, _IN_RESIDUES, given)
        for name, derived, lowered in _energies(model, _Motion(model, point), held):
            if (derived - lowered) % PRIME:
                raise _disagreement(model, program, name)
    _AGREED[id(model)] = model


def _point(model: Model, number: int) -> Residues:
    """A random point at which T, V and R have values."""
    point = Residues(Random(f"{model.scene.digest} {number}"))
    point.define(model.energies.definitions)
    for energy in (model.energies.kinetic, model.energies.potential, model.energies.dissipation):
        point.value(energy)
    return point


def _coefficients(model: Model) -> Program:
    """All numbers that Programs compute with, as outputs of a Program of its own."""
    builder, links = Builder("coefficients", "What the Programs of a scene know of its chain."), model.scene.links
    parameters = Parameters(builder, model)
    tables = {name: getattr(parameters, name) for name in _TABLES}
    scalars = {"total_mass": parameters.total_mass, "gravity": parameters.gravity}
    if model.scene.has_cart:
        scalars["cart_mass"] = parameters.cart_mass
    of_cart = {"cart_damping": parameters.cart_damping, "cart_friction": parameters.cart_friction}
    scalars |= {name: value for name, value in of_cart.items() if value is not None}
    for name, table in tables.items():
        if table is not None:
            out = builder.output(f"found_{name}", (links,))
            with builder.loop("k", 0, links) as loop:
                out[loop.index] = table[loop.index]
    for name, value in scalars.items():
        builder.output(f"found_{name}", ())[0] = value
    return prune(builder.finish())


def _symbols(model: Model) -> dict[str, list[sympy.Expr]]:
    """The symbols of the runtime parameters, in the order of the params struct."""
    scene = model.scene
    return {
        name: list(parameter(scene, name)) if name in PER_LINK else [single(scene, name)] for name in scene.runtime
    }


class _Motion:
    """Places and rates of a chain at a random point, as residues."""

    def __init__(self, model: Model, point: Residues) -> None:
        symbols, self.point = model.symbols, point
        self.cart, self.base_rate = ([*map(point.value, base)] for base in (symbols.cart, symbols.base_rate))
        self.base = [*map(point.value, symbols.along_base(symbols.base_rate))]
        if model.scene.is_planar:
            kind = str(model.scene.angles)
            phi = absolute_angles(kind, [point.angle(theta) for theta in symbols.theta])
            phi_dot = absolute_angles(kind, [point.value(rate) for rate in symbols.theta_dot])
            circles = [angle.circle for angle in phi]
            self.direction = [[sine, cosine] for cosine, sine in circles]
            self.rate = [[cos * rate, -sin * rate] for (cos, sin), rate in zip(circles, phi_dot, strict=True)]
            self.bends = [own - inner for inner, own in pairwise([0, *(p.value for p in phi)])]
            spins = [[rate] for rate in phi_dot]
        else:
            self.direction, self.rate, spins = (
                [[*map(point.value, vector)] for vector in vectors]
                for vectors in (symbols.links, symbols.link_rates, symbols.omega)
            )
            self.bends = [1 - _dot(inner, own) for inner, own in pairwise([[0, 0, 1], *self.direction])]
        self.slips = [
            [own - before for own, before in zip(spin, inner, strict=True)]
            for inner, spin in pairwise([[0] * len(spins[0]), *spins])
        ]


def _energies(model: Model, motion: _Motion, held: Values) -> Iterator[tuple[str, int, int]]:
    """(name, the Model's value, the Programs' value) of everything that must agree, as residues."""
    value, written = motion.point.value, model.scene.links <= _WRITTEN_OUT
    kinetic, potential = value(model.energies.kinetic), value(model.energies.potential)
    moment = sum(mu * q[-1] for mu, q in zip(held["found_mu"], motion.direction, strict=True))
    rotors = sum(a * _dot(slip, slip) for a, slip in zip(held.get("found_armature", ()), motion.slips, strict=False)) * _HALF
    yield from _places(model, motion, held)
    yield "T", kinetic, _by_masses(motion, held) + rotors
    yield "T", kinetic, _by_moments(motion, held) + rotors
    yield "S", value(names_of(model.scene).moment), moment
    yield "V", potential, _springs(model, motion, held) - held["found_gravity"][0] * moment
    yield "R", value(model.energies.dissipation), _losses(model, motion, held)
    if written:
        yield "T as it is written out", value(model.kinetic), kinetic
        yield "V as it is written out", value(model.potential), potential


def _springs(model: Model, motion: _Motion, held: Values) -> int:
    """1/2 k_k (theta_k - alpha_k)^2 in the plane, k_k (1 - q_{k-1}.q_k) in space."""
    stored, rest = motion.bends, held.get("found_rest_angle", [0] * len(motion.bends))
    if model.scene.is_planar:
        stored = [pow(bend - alpha, 2, PRIME) * _HALF for bend, alpha in zip(stored, rest, strict=True)]
    return sum(k * bend for k, bend in zip(held.get("found_stiffness", ()), stored, strict=False))


def _losses(model: Model, motion: _Motion, held: Values) -> int:
    """R of dampers and dry friction, the cart's among them."""
    twice = sum(d * _dot(slip, slip) for d, slip in zip(held.get("found_damping", ()), motion.slips, strict=False))
    twice += sum(d * _dot(motion.base_rate, motion.base_rate) for d in held.get("found_cart_damping", ()))
    rubbed = [(held.get("found_cart_friction", ()), [motion.base_rate], model.scene.cart_friction_speed)]
    rubbed.append((held.get("found_friction", ()), motion.slips, model.scene.friction_speed))
    total = twice * _HALF
    for forces, rates, speed in rubbed:
        v_0 = _residue(Fraction(speed or 1))
        total += sum(f * v_0 * motion.point.log_cosh(_size(motion, rate, v_0)) for f, rate in zip(forces, rates, strict=False))
    return total


def _size(motion: _Motion, rate: Sequence[int], v_0: int) -> int:
    """v / v_0 in the plane, the root of |w|^2 / v_0^2 and a little in space."""
    over = inverse(v_0)
    if len(rate) == 1:
        return rate[0] * over
    return motion.point.root((_dot(rate, rate) * over * over + _residue(LEAST_SQUARE)) % PRIME)


def _places(model: Model, motion: _Motion, held: Values) -> Iterator[tuple[str, int, int]]:
    """Where every mass is."""
    names = names_of(model.scene)
    base = [*motion.cart, *([0] * (names.axes - len(motion.cart)))]
    for k, link in enumerate(motion.direction):
        own, arm = held["found_com"][k], held["found_length"][k]
        for symbol, b, q in zip(names.mass(k + 1), base, link, strict=True):
            yield f"{symbol}, a place", motion.point.value(symbol), b + own * q
        base = [(b + arm * q) % PRIME for b, q in zip(base, link, strict=True)]


def _by_masses(motion: _Motion, held: Values) -> int:
    """T of the masses on their way, from m_k, r_k, l_k, J_k and m_0."""
    base = motion.base
    twice = sum(m * _dot(base, base) for m in held.get("found_cart_mass", ()))
    for k, rate in enumerate(motion.rate):
        own, arm = held["found_com"][k], held["found_length"][k]
        mass = [b + own * r for b, r in zip(base, rate, strict=True)]
        base = [(b + arm * r) % PRIME for b, r in zip(base, rate, strict=True)]
        twice += held["found_mass"][k] * _dot(mass, mass)
    twice += sum(own * _dot(rate, rate) for own, rate in zip(held.get("found_inertia", ()), motion.rate, strict=False))
    return twice * _HALF


def _by_moments(motion: _Motion, held: Values) -> int:
    """T from M00, mu_k, c_kk and c_ij = l_i mu_j, i < j."""
    twice = held["found_total_mass"][0] * _dot(motion.base_rate, motion.base_rate)
    inner = motion.base
    for k, rate in enumerate(motion.rate):
        twice += held["found_c_diagonal"][k] * _dot(rate, rate) + 2 * held["found_mu"][k] * _dot(inner, rate)
        inner = [(b + held["found_length"][k] * r) % PRIME for b, r in zip(inner, rate, strict=True)]
    return twice * _HALF


def _disagreement(model: Model, program: Program, energy: str) -> DerivationError:
    """The error that names the first coefficient that differs, with both values; else the energy as a whole."""
    held = run(program, _EXACTLY, _symbols(model))
    point = Residues(Random(model.scene.digest))
    for name, derived, lowered in _pairs(model, held):
        if point.value(exact(derived)) != point.value(exact(lowered)):
            problem = f"in the Model's Lagrangian is not the {_shown(lowered)} that the Programs compute with"
            return DerivationError(f"Lagrangian.{name}", _Written(_shown(derived)), problem, _REMEDY)
    whole = {"S": "first moment S", "R": "Rayleigh function R"}.get(energy, energy)
    problem = "is not the form whose coefficients the Programs compute with, though those that it shares with it agree"
    return DerivationError(f"Lagrangian.{energy.split()[0].rstrip(',')}", whole, problem, _REMEDY)


def _pairs(model: Model, held: Values) -> Iterator[tuple[str, Coefficient, Coefficient]]:
    """(name, value in the Lagrangian, value in the Programs) of every coefficient."""
    mass, length, com = (held[f"found_{name}"] for name in ("mass", "length", "com"))
    links = range(model.scene.links)
    beyond = [sum(mass[k + 1 :], Fraction(0)) for k in links]
    mu = [mass[k] * com[k] + length[k] * beyond[k] for k in links]
    spin = held.get("found_inertia", [Fraction(0)] * len(links))
    diagonal = [mass[k] * com[k] * com[k] + spin[k] + length[k] * length[k] * beyond[k] for k in links]
    if not model.scene.base_law.rests:
        yield "M00", model.total_mass, sum((*mass, *held.get("found_cart_mass", ())), Fraction(0))
        yield "M00", model.total_mass, held["found_total_mass"][0]
        yield from _listed("coupling", model.coupling, mu)
    for found in (diagonal, held["found_c_diagonal"]):
        yield from _listed("c", model.c_diagonal, found, twice=True)
    for found in (mu, held["found_mu"]):
        yield from _listed("mu", model.mu, found)
    yield "g", model.gravity, held["found_gravity"][0]
    still = [Fraction(0)] * len(links)
    yield from _listed("k", model.stiffness, held.get("found_stiffness", still))
    yield from _listed("d", model.damping, held.get("found_damping", still))
    yield from _listed("A", model.armature, held.get("found_armature", still))
    yield from _listed("F", model.friction, held.get("found_friction", still))
    yield from _listed("alpha", model.rest_angle, held.get("found_rest_angle", still))
    for name in ("cart_damping", "cart_friction"):
        yield name, getattr(model, name), held.get(f"found_{name}", still)[0]
    for i, row in enumerate(model.c):
        yield from ((f"c_{i + 1}_{j + 1}", row[j], length[i] * mu[j]) for j in links[i + 1 :])


def _listed(
    name: str, derived: Sequence[Coefficient], lowered: Sequence[Coefficient], twice: bool = False
) -> Iterator[tuple[str, Coefficient, Coefficient]]:
    for k, (own, other) in enumerate(zip(derived, lowered, strict=True), 1):
        yield f"{name}_{k}_{k}" if twice else f"{name}_{k}", own, other


class _Written(str):
    """A value that an error shows as it is."""

    def __repr__(self) -> str:
        return str(self)


def _shown(value: Coefficient) -> str:
    return str(value) if not isinstance(value, Fraction) or value.denominator == 1 else repr(float(value))


def _dot(a: Sequence[int], b: Sequence[int]) -> int:
    return sum(x * y for x, y in zip(a, b, strict=True)) % PRIME


def _residue(value: Fraction) -> int:
    return value.numerator * inverse(value.denominator) % PRIME


#: Models that passed: one is lowered function by function.
_AGREED: Final[WeakValueDictionary[int, Model]] = WeakValueDictionary()
_TABLES: Final = (
    "mass", "length", "com", "mu", "c_diagonal", "stiffness", "damping", "inertia", "armature", "friction", "rest_angle",
)  # fmt: skip
_HALF: Final = inverse(2)
_RESIDUES: Final[Mapping[str, Callable[..., int]]] = {
    "add": lambda a, b: a + b, "sub": lambda a, b: a - b, "mul": lambda a, b: a * b, "neg": lambda a: -a,
    "div": lambda a, b: a * inverse(b),
}  # fmt: skip
_IN_RESIDUES: Final = Algebra(_residue, lambda kind, args, label: _RESIDUES[kind](*args) % PRIME)
_EXACT: Final[Mapping[str, Callable[..., Any]]] = {
    "add": operator.add, "sub": operator.sub, "mul": operator.mul, "neg": operator.neg, "div": operator.truediv,
}  # fmt: skip
_EXACTLY: Final = Algebra(lambda value: value, lambda kind, args, label: _EXACT[kind](*args))
