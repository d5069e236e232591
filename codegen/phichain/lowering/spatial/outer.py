"""The chain beyond a joint of a spatial articulated sweep, and how it looks from the next link inwards.

It asks for the force A a + f at the joint, a the joint's acceleration minus gravity. Split at its own first link, of direction o,

    A = alpha u u^T + G,   f = c A o + d,   u = o + nu;   nu, d and G tangent to o,   g = det G,   rho = adj(G) d,

det and adj those of the tangent plane. All of alpha, G and g are sums of positive terms, and a chain that only pulls along o
has nu, d, G and rho zero. With K = adj A = g o o^T + alpha hat(u) G hat(u)^T and E = det A = alpha g, everything that a link of
another direction q needs follows without a difference of large numbers: with x = q x u, P = I - q q^T and
turned(S) = hat(q) S hat(q)^T,

    P A q = alpha (q.u) P u + P G q,   K q = g (q.o) o + alpha u x G x,   K_qq = g (q.o)^2 + alpha x.G x
    K f = c E o + alpha (rho - (nu.rho) o),   turned(A) f = alpha (d.x) x - c alpha q x G x + (q.o) ((q.o) rho - (q.rho) o)
    Y = A q x f = alpha (q.u) u x d + c alpha G q x u + y o,   A Y = alpha (y u + (q.u) o x rho + c g q x o),   y = rho.(o x q)
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

from phichain.ir.builder import Expr
from phichain.lowering.algebra.matrix import Matrix, applied, combine, dyads, symmetric, trace, triangle
from phichain.lowering.algebra.vector import Vector, add, cross, dot, scale, sub


@dataclass(frozen=True)
class Outer:
    """The chain beyond a joint, split at its first link: o, alpha, nu, G, g, c, d and rho in this order.

    Beyond two links G is one dyad, f w w^T. As a matrix it is good to a rounding of its norm, and of x.G x nothing may be left where x is
    almost across w; `dyad` (f, w) keeps (w.x)^2.
    """

    direction: Vector
    axial: Expr
    lean: Vector
    tangent: Matrix
    area: Expr
    pull: Expr
    push: Vector
    minor: Vector
    dyad: tuple[Expr, Vector] | None = None

    def on(self, vector: Vector) -> Vector:
        """G times a vector."""
        if self.dyad is None:
            return applied(self.tangent, vector)
        factor, direction = self.dyad
        return scale(factor * dot(direction, vector), direction)

    def flat(self) -> list[Expr]:
        """All scalars in a fixed order, for a loop to carry; no dyad."""
        return [
            *self.direction, self.axial, *self.lean, *triangle(self.tangent), self.area, self.pull, *self.push, *self.minor,
        ]  # fmt: skip

    @staticmethod
    def from_flat(values: Sequence[Expr]) -> Outer:
        """The inverse of `flat`."""
        take = iter(values)

        def vector() -> Vector:
            return next(take), next(take), next(take)

        direction, axial, lean = vector(), next(take), vector()
        return Outer(
            direction, axial, lean, symmetric((*vector(), *vector())), next(take), next(take), vector(), vector()
        )


class Seen:
    """An `Outer` as a link of direction q and own inertia beta^2 meets it; every quantity is made on first use."""

    def __init__(self, outer_chain: Outer, q: Vector, own: Expr) -> None:
        self.outer, self.q, self.own = outer_chain, q, own
        self.u = add(outer_chain.direction, outer_chain.lean)
        self.along_o = dot(q, outer_chain.direction)
        self.across_o = cross(q, outer_chain.direction)
        self.tangent_o = cross(self.across_o, q)
        self.along_u = self.along_o + dot(q, outer_chain.lean)
        self.x = add(self.across_o, cross(q, outer_chain.lean))
        self.tangent_q = outer_chain.on(q)
        self.tangent_x = outer_chain.on(self.x)
        self.tangent_qq = dot(q, self.tangent_q)
        self.tangent_xx = dot(self.x, self.tangent_x)

    def projected(self, vector: Vector, along: Expr | None = None) -> Vector:
        """P vector; `along` is q.vector where it is known."""
        return sub(vector, scale(dot(self.q, vector) if along is None else along, self.q))

    @cached_property
    def projector(self) -> Matrix:
        """P."""
        one, nothing = self.q[0].builder.lift(1), self.q[0].builder.lift(0)
        return combine((1, symmetric((one, nothing, nothing, one, nothing, one))), (-1, dyads(self.q, self.q)))

    @cached_property
    def tangent_u(self) -> Vector:
        """P u."""
        return cross(self.x, self.q)

    @cached_property
    def pressed(self) -> Vector:
        """P G q."""
        return self.projected(self.tangent_q, self.tangent_qq)

    @cached_property
    def tangent(self) -> Matrix:
        """P G P."""
        return combine((1, self.outer.tangent), (-1, dyads(self.q, self.pressed, self.tangent_q, self.q)))

    @cached_property
    def tangent_trace(self) -> Expr:
        """tr P G P."""
        return trace(self.outer.tangent) - self.tangent_qq

    @cached_property
    def across_trace(self) -> Expr:
        """beta^2 + tr P G P."""
        return self.own + self.tangent_trace

    @cached_property
    def trace(self) -> Expr:
        """tr P A P."""
        return self.outer.axial * dot(self.x, self.x) + self.tangent_trace

    @cached_property
    def mixed(self) -> Vector:
        """P A q."""
        return add(scale(self.outer.axial * self.along_u, self.tangent_u), self.pressed)

    @cached_property
    def axial(self) -> Expr:
        """q.A q"""
        return self.outer.axial * (self.along_u * self.along_u) + self.tangent_qq

    @cached_property
    def determinant(self) -> Expr:
        """E."""
        return self.outer.axial * self.outer.area

    @cached_property
    def adjugate_axial(self) -> Expr:
        """K_qq = det of A in the plane across q."""
        return self.outer.area * (self.along_o * self.along_o) + self.outer.axial * self.tangent_xx

    @cached_property
    def adjugate_mixed(self) -> Vector:
        """P K q."""
        beyond = self.projected(cross(self.u, self.tangent_x), self.tangent_xx)
        return add(scale(self.outer.area * self.along_o, self.tangent_o), scale(self.outer.axial, beyond))

    @cached_property
    def adjugate_trace(self) -> Expr:
        """tr P K P."""
        squared, pressed = self.along_u * self.along_u, dot(self.tangent_u, self.tangent_q)
        spread = (
            self.tangent_qq * dot(self.x, self.x)
            - 2 * (self.along_u * pressed)
            + squared * self.tangent_trace
        )
        return self.outer.area * dot(self.across_o, self.across_o) + self.outer.axial * spread

    # --- along u ------------------------------------------------------------------------------------------------------

    @cached_property
    def share(self) -> Expr:
        """D u.(q - sigma)"""
        chain = self.outer
        along = self.along_u * (self.across_trace + self.tangent_qq) - dot(chain.lean, self.tangent_q)
        return self.own * along + chain.area * self.along_o

    @cached_property
    def yielding_u(self) -> Vector:
        """(beta^2 P + turned(A)) u"""
        return sub(scale(self.own, self.tangent_u), cross(self.q, self.tangent_x))

    @cached_property
    def free_u(self) -> Expr:
        """D c - u.(beta^2 P + turned(A)) f"""
        chain = self.outer
        pulled = chain.pull * (self.own * self.across_trace + chain.area * (self.along_o * self.along_o))
        return pulled - self.own * self.push_u + self.along_o * (self.minor_along - self.minor_lean * self.along_o)

    def turned(self, vector: Vector) -> Vector:
        """turned(A) of a vector tangent to q."""
        beyond = cross(self.q, self.outer.on(cross(vector, self.q)))
        return add(scale(self.outer.axial * dot(self.x, vector), self.x), beyond)

    def adjugate(self, vector: Vector) -> Vector:
        """P K of any vector."""
        o, u = self.outer.direction, self.u
        beyond = cross(u, self.outer.on(cross(vector, u)))
        return self.projected(
            add(scale(self.outer.area * dot(o, vector), o), scale(self.outer.axial, beyond))
        )

    # --- the bias force f ---------------------------------------------------------------------------------------------

    @cached_property
    def heavy_pull(self) -> Expr:
        """alpha c."""
        return self.outer.axial * self.outer.pull

    @cached_property
    def push_along(self) -> Expr:
        """q.d"""
        return dot(self.q, self.outer.push)

    @cached_property
    def minor_along(self) -> Expr:
        """q.rho"""
        return dot(self.q, self.outer.minor)

    @cached_property
    def minor_lean(self) -> Expr:
        """nu.rho"""
        return dot(self.outer.lean, self.outer.minor)

    @cached_property
    def push_u(self) -> Expr:
        """(P u).d"""
        return dot(self.tangent_u, self.outer.push)

    @cached_property
    def minor_turned(self) -> Vector:
        """(o x rho) x q"""
        return sub(scale(self.along_o, self.outer.minor), scale(self.minor_along, self.outer.direction))

    @cached_property
    def force(self) -> Vector:
        """P f."""
        return add(scale(self.heavy_pull, self.tangent_u), self.projected(self.outer.push, self.push_along))

    @cached_property
    def turned_force(self) -> Vector:
        """turned(A) f."""
        push_x = dot(self.outer.push, self.x)
        straight = sub(
            scale(self.outer.axial * push_x, self.x), scale(self.heavy_pull, cross(self.q, self.tangent_x))
        )
        return add(straight, scale(self.along_o, self.minor_turned))

    @cached_property
    def adjugate_force(self) -> Vector:
        """P K f."""
        minor = self.projected(self.outer.minor, self.minor_along)
        return add(scale(self._pull_minor, self.tangent_o), scale(self.outer.axial, minor))

    @cached_property
    def _pull_minor(self) -> Expr:
        """c E - alpha nu.rho, the part of K f along o."""
        return self.outer.pull * self.determinant - self.outer.axial * self.minor_lean

    @cached_property
    def axial_push(self) -> Expr:
        """q.(beta^4 d + beta^2 (tr A - A) d + K d): what d leaves of the force along q once the link has turned."""
        turning = self.along_u * self.push_u - dot(self.x, self.x) * self.push_along
        beyond = self.minor_along - self.minor_lean * self.along_o
        turned = self.own * self.push_along + (self.minor_along - self.outer.axial * turning)
        return self.own * turned + self.outer.axial * beyond

    @cached_property
    def crossed(self) -> Vector:
        """(beta^2 Y + A Y) x q, Y = A q x f."""
        chain, axial = self.outer, self.outer.axial
        y = -dot(chain.minor, self.across_o)
        driven = sub(scale(axial * self.along_u, chain.push), scale(self.heavy_pull, self.tangent_q))
        along = axial * self.along_u * self.push_along - self.heavy_pull * self.tangent_qq
        first = sub(scale(self.along_u, driven), scale(along, self.u))
        heavy = sub(scale(self.along_u, self.minor_turned), scale(y, self.x))
        heavy = add(heavy, scale(chain.pull * chain.area, self.tangent_o))
        return add(scale(self.own, sub(first, scale(y, self.across_o))), scale(axial, heavy))
