"""T, V and R straight from the positions of the point masses, in the field and from the scene alone: what a Lagrangian is held to.

Nothing of `mechanics` takes part, so a Model whose T was doubled is told apart even when its Programs follow it. Where masses sit, what
springs store and what dampers take is written down here once more (theory section 1):

    b_0 = C x,    r_k = b_{k-1} + r_k q_k,    b_k = b_{k-1} + l_k q_k
    T = 1/2 m_0 |x'|^2 + 1/2 sum (m_k |r_k'|^2 + J_k |q_k'|^2) + rotors,    V = -g sum m_k e_d.r_k + springs,
    R = 1/2 d_0 |x'|^2 + 1/2 sum d_k |rate_k - rate_{k-1}|^2 + F_0 v_0 ln cosh(x' / v_0) + sum F_k v_0 ln cosh((rate_k - rate_{k-1}) / v_0)

where rotors, of planar chains, are 1/2 sum A_k |rate_k - rate_{k-1}|^2.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise
from typing import Any

from phichain.contract.chain import LEAST_SQUARE
from phichain.proof.modular.field import HALF, PRIME, Vector, cross, dot, exact, inverse, plus
from phichain.proof.modular.points import Point


@dataclass(eq=False)
class Chain:
    """A scene's numbers in the field, and what they say at one point.

    Attributes:
        point: where.
        kept: what identities make of it once for several functions.
    """

    point: Point
    kept: dict[str, Any] = field(default_factory=dict)
    _known: dict[str, Vector] = field(default_factory=dict)

    def per_link(self, name: str) -> Vector:
        """A parameter of every link; zeros where there is none."""
        if name not in self._known:
            self._known[name] = self._per_link(name)
        return self._known[name]

    def _per_link(self, name: str) -> Vector:
        value = getattr(self.point.scene, name)
        if value is None:
            return self.per_link("length") if name == "com" else [0] * self.point.scene.links
        return self.point.parameters[name] if isinstance(value, str) else [exact(entry) for entry in value]

    def single(self, name: str) -> int:
        """A parameter of the whole chain; zero where there is none."""
        value = getattr(self.point.scene, name)
        return self.point.parameters[name][0] if isinstance(value, str) else exact(value or 0)

    @cached_property
    def outer_mass(self) -> Vector:
        """The mass beyond each link."""
        total, found = 0, []
        for mass in reversed(self.per_link("mass")):
            found.append(total)
            total = (total + mass) % PRIME
        return found[::-1]

    @cached_property
    def mu(self) -> Vector:
        """The first moments mu_k = sum_a m_a times the lever of link k."""
        return [
            (m * r + length * outer) % PRIME
            for m, r, length, outer in zip(*map(self.per_link, ("mass", "com", "length")), self.outer_mass, strict=True)
        ]

    @cached_property
    def moments(self) -> Vector:
        """The second moments c_kk."""
        return [
            (m * r * r + own + length * length * outer) % PRIME
            for m, r, length, own, outer in zip(
                *map(self.per_link, ("mass", "com", "length", "inertia")), self.outer_mass, strict=True
            )
        ]

    @property
    def total_mass(self) -> int:
        """M00."""
        return (self.single("cart_mass") + sum(self.per_link("mass"))) % PRIME

    @cached_property
    def turns(self) -> list[tuple[int, int, tuple[int, int]]]:
        """(phi_k, phi_k', their point of the circle) of a planar chain."""
        point, found = self.point, list[tuple[int, int, tuple[int, int]]]()
        entries = list(zip(point.q, point.v, point.circles, strict=True))[point.carts :]
        for k, (angle, rate, (c, s)) in enumerate(entries):
            before = {"absolute": None, "relative": found[-1:], "adjacent": entries[k - 1 : k] if k else None}[
                str(point.scene.angles)
            ]
            if before:
                inner, turning, (C, S) = before[0]
                angle, rate, (c, s) = angle + inner, rate + turning, (c * C - s * S, s * C + c * S)
            found.append((angle % PRIME, rate % PRIME, (c % PRIME, s % PRIME)))
        return found

    @cached_property
    def directions(self) -> list[Vector]:
        """q_k by component, the last one along gravity."""
        if self.point.scene.is_planar:
            return [[s, c] for _, _, (c, s) in self.turns]
        return self.point.links

    @cached_property
    def rates(self) -> list[Vector]:
        """q_k'."""
        if self.point.scene.is_planar:
            return [[c * rate % PRIME, -s * rate % PRIME] for _, rate, (c, s) in self.turns]
        return [cross(omega, link) for omega, link in zip(self.omega, self.directions, strict=True)]

    @cached_property
    def omega(self) -> list[Vector]:
        """omega_k of a spatial chain."""
        return [self.point.v[i : i + 3] for i in range(self.point.carts, len(self.point.v), 3)]

    def places(self, start: Sequence[int], vectors: Sequence[Vector]) -> list[Vector]:
        """r_k from x and q_k, or r_k' from x' and q_k'."""
        base, found = [*start, *[0] * (len(vectors[0]) - len(start))], []
        for vector, com, length in zip(vectors, self.per_link("com"), self.per_link("length"), strict=True):
            found.append(plus(base, vector, com))
            base = plus(base, vector, length)
        return found

    def energies(self, drift: Sequence[int] = ()) -> dict[str, list[int]]:
        """T, gravity's part of V, V, R and the positions, as the Lagrangian's compiled form names them; on a base of that velocity."""
        point, mass, carts = self.point, self.per_link("mass"), self.point.carts
        start = [*point.v[:carts], *drift]
        places, speeds = self.places(point.q[:carts], self.directions), self.places(start, self.rates)
        twice = sum(m * dot(speed, speed) for m, speed in zip(mass, speeds, strict=True))
        twice += sum(own * dot(rate, rate) for own, rate in zip(self.per_link("inertia"), self.rates, strict=True))
        twice += self.single("cart_mass") * dot(point.v[:carts], point.v[:carts]) + self._rotors()
        fall = sum(m * place[-1] for m, place in zip(mass, places, strict=True))
        weight = -self.single("gravity") * fall % PRIME
        return {
            "kinetic": [twice * HALF % PRIME],
            "weight": [weight],
            "potential": [(weight + dot(self.per_link("stiffness"), self._bends())) % PRIME],
            "dissipation": [(self._drag() + self._dry()) % PRIME],
            "positions": [entry for place in places for entry in place],
        }

    def _drag(self) -> int:
        """R of the dampers."""
        speed = self.point.v[: self.point.carts]
        squares = [dot(slip, slip) for slip in self._slips()]
        return (self.single("cart_damping") * dot(speed, speed) + dot(self.per_link("damping"), squares)) * HALF

    def _dry(self) -> int:
        """R of dry friction."""
        scene, forces, rates = self.point.scene, list[int](), list[int]()
        if scene.cart_friction_speed is not None:
            over = inverse(exact(scene.cart_friction_speed))
            forces.append(self.single("cart_friction") * exact(scene.cart_friction_speed))
            rates.append(self._size(self.point.v[: self.point.carts], over))
        if scene.friction_speed is not None:
            over = inverse(exact(scene.friction_speed))
            forces += [force * exact(scene.friction_speed) for force in self.per_link("friction")]
            rates += [self._size(slip, over) for slip in self._slips()]
        return sum(force * self.point.log_cosh(rate) for force, rate in zip(forces, rates, strict=True))

    def _size(self, rate: Vector, over: int) -> int:
        """v / v_0 in the plane, the root of |w|^2 / v_0^2 and a little in space."""
        if len(rate) == 1:
            return rate[0] * over % PRIME
        return self.point.root((dot(rate, rate) * over * over + exact(LEAST_SQUARE)) % PRIME)

    def _bends(self) -> Vector:
        """(phi_k - phi_{k-1} - alpha_k)^2 / 2, or 1 - q_{k-1}.q_k."""
        if self.point.scene.is_planar:
            angles = [0, *(angle for angle, _, _ in self.turns)]
            rests = self.per_link("rest_angle")
            return [(outer - inner - rest) ** 2 * HALF for (inner, outer), rest in zip(pairwise(angles), rests, strict=True)]
        return [1 - dot(inner, outer) for inner, outer in zip([[0, 0, 1], *self.directions], self.directions, strict=False)]

    def _slips(self) -> list[Vector]:
        """rate_k - rate_{k-1}."""
        spins = [[rate] for _, rate, _ in self.turns] if self.point.scene.is_planar else self.omega
        still = [0] * len(spins[0])
        return [plus(outer, inner, -1) for inner, outer in zip([still, *spins], spins, strict=False)]

    def _rotors(self) -> int:
        """Twice the energy of the rotors."""
        return dot(self.per_link("armature"), [dot(slip, slip) for slip in self._slips()])

    def collected_kinetic(self, drift: Sequence[int] = ()) -> int:
        """T from M00, mu_k, c_kk and c_ij = l_i mu_j: what shows that those are the coefficients of T."""
        start = [*self.point.v[: self.point.carts], *drift]
        twice = self.total_mass * dot(start, start) + self._rotors()
        inner = [*start, *[0] * (len(self.rates[0]) - len(start))]
        for k, rate in enumerate(self.rates):
            twice += self.moments[k] * dot(rate, rate) + 2 * self.mu[k] * dot(inner, rate)
            inner = plus(inner, rate, self.per_link("length")[k])
        return twice * HALF % PRIME
