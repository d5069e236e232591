"""The answers of a spatial chain with its masses at the links' ends, free of cancellation.

There W = (I - gamma u u^T) / m, gamma = alpha' / (m + alpha'), u and alpha' those of the next link, and kappa = 0, v = q; with x = q x u

    alpha = m / ((1 - gamma) + gamma x.x),   q x w = -gamma (q.u) x / m,   m^2 C / alpha = (1 - gamma) (I - q q^T) + gamma x x^T
"""

from __future__ import annotations

from phichain.ir.builder import ArrayRef, Builder, Expr, Index
from phichain.lowering.algebra.matrix import Matrix, scaled, symmetric
from phichain.lowering.algebra.vector import Vector, dot, load, scale, store, sub
from phichain.lowering.parameters import Parameters
from phichain.lowering.spatial.jacobian.response import Link
from phichain.lowering.spatial.links import directions
from phichain.lowering.spatial.tension import Tensions
from phichain.scene import Scene


class EndMasses:
    """The answers of a chain with its masses at the links' ends: P has rank one, so that a perturbation goes on as w times one number."""

    rank = 1

    def __init__(self, builder: Builder, scene: Scene, parameters: Parameters, q: ArrayRef, found: Tensions) -> None:
        self.builder, self.parameters, self.found = builder, parameters, found
        self.direction = directions(scene, q)
        self.inverse_length = parameters.derived("inverse_length", lambda k: 1 / parameters.length[k])
        links = scene.links
        names = ("axial", "beyond_share", "own_share")
        self.axial, self.gamma, self.rest = (builder.array(name, links) for name in names)
        self.axis, self.turned = builder.array("tension_axis", 3 * links), builder.array("turned_axis", 3 * links)
        self._inwards(links - 1)

    def _inwards(self, tip: int) -> None:
        builder, mass = self.builder, self.parameters.mass
        nothing, one = builder.lift(0), builder.lift(1)
        self.axial[tip], self.gamma[tip], self.rest[tip] = mass[tip], nothing, one
        store(self.axis, tip, scale(1 / mass[tip], load(self.direction, tip)))
        store(self.turned, tip, (nothing, nothing, nothing))
        with builder.loop("k", tip - 1, -1, -1) as loop:
            k = loop.index
            beyond = loop.carry("axial_beyond", mass[tip])
            inverse = builder.let("inverse_mass_beyond", 1 / (mass[k] + beyond))
            self.gamma[k] = gamma = builder.let("share_beyond", beyond * inverse)
            self.rest[k] = rest = builder.let("share_here", mass[k] * inverse)
            across = load(self.found.crosses, k + 1)
            self.axial[k] = axial = builder.let("axial_here", mass[k] / (rest + gamma * dot(across, across)))
            lean = builder.let("lean", gamma * self.found.cosine[k + 1])
            own = sub(load(self.direction, k), scale(lean, load(self.direction, k + 1)))
            store(self.axis, k, scale(1 / mass[k], own))
            # crosses[k + 1] is u x q
            store(self.turned, k, scale(lean * (self.inverse_length[k] / mass[k]), across))
            loop.follow(beyond, axial)

    def link(self, k: Index) -> Link:
        """The answers of link k."""
        q, axial, mass = load(self.direction, k), self.axial[k], self.parameters.mass[k]
        # the multiplier draws outwards, the tension inwards
        multiplier = -(self.found.tension[k] * mass)
        held = self._held(k, q)
        return Link(
            q, self.inverse_length[k], axial, load(self.axis, k), q, load(self.turned, k), held, None, multiplier
        )  # fmt: skip

    def _held(self, k: Index, q: Vector) -> Matrix:
        builder, mass = self.builder, self.parameters.mass[k]
        share = builder.let("held_share", self.axial[k] / (mass * mass))
        plane, along = builder.let("held_plane", share * self.rest[k]), builder.let("held_along", share * self.gamma[k])
        x = load(self.found.crosses, k + 1)
        leaning = scale(along, x)
        steep = scale(plane, q)
        entries = []
        for i in range(3):
            for j in range(i, 3):
                whole = plane - steep[i] * q[j] if i == j else -(steep[i] * q[j])
                entries.append(whole + leaning[i] * x[j])
        return symmetric(entries)

    def turned_before(self, k: Index) -> Vector:
        """J_k w_{k-1}."""
        return scale(self.inverse_length[k] / self.parameters.mass[k - 1], load(self.found.crosses, k))

    def base(self, cart_mass: Expr) -> Matrix:
        """Omega of the base of a chain on a cart: the inverse of m_c I + alpha h h^T, all horizontal."""
        nothing, axial = self.builder.lift(0), self.axial[0]
        x, y, _ = load(self.direction, 0)
        inverse = self.builder.let("inverse_base_pivot", 1 / (cart_mass * (cart_mass + axial * (x * x + y * y))))
        rows = symmetric((cart_mass + axial * (y * y), -(axial * (x * y)), nothing, cart_mass + axial * (x * x), nothing, nothing))
        return scaled(inverse, rows)
