"""Spatial forward dynamics with masses anywhere on their links: an articulated sweep on unit vectors.

The chain beyond a joint asks for the force A a + f, a the joint's acceleration minus gravity. Seen from a unit vector q,
a symmetric matrix splits into A = alpha q q^T + q beta^T + beta q^T + Gamma, beta and Gamma tangent to q. For a link with mass
m at r along q, length l, kappa = l - r, h = m r^2, and D = h + l^2 Gamma on the tangent plane, eliminating the link's rotation
q'' = t - |omega|^2 q, D t = p - l beta (q.a) - (m r + l Gamma) a, gives A' = m I + A - U^T D^-1 U. Written out, every
subtraction cancels symbolically when the adjugate K = adj(A) (split likewise) and E = det(A) are carried along:

    det D = h^2 + h l^2 tr Gamma + l^4 K_qq
    alpha' = m + (alpha h^2 + h l^2 tr K_tt + l^4 E) / det D
    beta'  = -m r kappa D^-1 beta,               Gamma' = m kappa^2 (h Gamma + l^2 K_qq P) / det D
    K'_qq  = m^2 kappa^4 K_qq / det D,           K'_q = -m^2 r kappa^3 K_q / det D
    K'_tt  = m kappa^2 (m (h adj Gamma + l^2 K_qq P) + h K_tt + l^2 E P) / det D
    E'     = m^2 kappa^4 (m K_qq + E) / det D

P = -hat(q)^2 is the tangent projector, adj Gamma = hat(q) A hat(q)^T, D^-1 = (h P + l^2 adj Gamma) / det D. All scalars are sums of
positive terms. Tangent vectors and matrices of the outer link are split anew at the inner one through cross products alone.
"""

from __future__ import annotations

from dataclasses import dataclass

from phichain.program.builder import ArrayRef, Builder, Expr, Index
from phichain.program.parameters import Parameters
from phichain.program.spatial_links import couples, directions
from phichain.program.vector import (
    Symmetric,
    Vector,
    add,
    combine,
    cross,
    dot,
    load,
    outer,
    scale,
    store,
    symmetric_outer,
    times,
    turned,
)
from phichain.scene import Scene


@dataclass(frozen=True)
class _Split:
    """S = axial q q^T + q mixed^T + mixed q^T + tangent, as seen from a unit vector q."""

    axial: Expr
    mixed: Vector
    tangent: Symmetric


@dataclass(frozen=True)
class _Outer:
    """The chain beyond a joint: inertia A, adjugate K and bias force f, all split at `direction`, and E = det A."""

    direction: Vector
    inertia: _Split
    adjugate: _Split
    determinant: Expr
    bias_axial: Expr
    bias_tangent: Vector

    def flat(self) -> list[Expr]:
        """All scalars in a fixed order, for the loop to carry."""
        inertia, adjugate = self.inertia, self.adjugate
        return [
            *self.direction, inertia.axial, *inertia.mixed, *inertia.tangent, adjugate.axial, *adjugate.mixed,
            *adjugate.tangent, self.determinant, self.bias_axial, *self.bias_tangent,
        ]  # fmt: skip

    @staticmethod
    def from_flat(values: list[Expr]) -> _Outer:
        """The inverse of `flat`."""
        take = iter(values)

        def vector() -> Vector:
            return next(take), next(take), next(take)

        def split() -> _Split:
            axial, mixed, first, second = next(take), vector(), vector(), vector()
            return _Split(axial, mixed, (*first, *second))

        return _Outer(vector(), split(), split(), next(take), next(take), vector())


def accelerations(
    builder: Builder, scene: Scene, parameters: Parameters, q: ArrayRef, v: ArrayRef, u: ArrayRef | None, a: ArrayRef
) -> None:
    """Write the accelerations [x'', omega'] into `a`."""
    links = scene.links
    direction, omega = directions(scene, q), directions(scene, v)
    couple = couples(builder, scene, parameters, direction, omega)
    sweep = _Sweep(builder, parameters, direction, omega, couple)
    nothing = builder.lift(0)
    with builder.loop("k", links - 1, -1, -1) as loop:
        carried = [loop.carry("outer", nothing) for _ in range(28)]
        following = sweep.inwards(_Outer.from_flat(carried), loop.index)
        for before, after in zip(carried, following.flat(), strict=True):
            loop.follow(before, after)
    base: Vector = (nothing, nothing, -parameters.gravity)
    if scene.has_cart:
        unit = parameters.units.force
        force = (u[0] / unit, u[1] / unit) if u is not None else (nothing, nothing)
        cart = sweep.close_on_cart(_Outer.from_flat(carried), force)
        a[0], a[1] = cart[0] * parameters.units.length, cart[1] * parameters.units.length
        base = (cart[0], cart[1], base[2])
    sweep.outwards(base, directions(scene, a))


class _Sweep:
    """The inward elimination and the outward substitution; work arrays carry one to the other."""

    def __init__(
        self, builder: Builder, parameters: Parameters, direction: ArrayRef, omega: ArrayRef, couple: ArrayRef | None
    ) -> None:
        self.builder, self.parameters = builder, parameters
        self.direction, self.omega, self.couple = direction, omega, couple
        links = parameters.links
        self.free = builder.array("free", 3 * links)
        self.slope = builder.array("slope", 3 * links)
        self.gain = builder.array("gain", 6 * links)
        self.rate_squared = builder.array("rate_squared", links)

    def inwards(self, before: _Outer, k: Index) -> _Outer:
        """Eliminate the rotation of link k."""
        builder, mass, length = self.builder, self.parameters.mass[k], self.parameters.length[k]
        h, moment, skew, lever, _ = self._numbers(k)
        area = length * length
        q = load(self.direction, k)
        inertia, gamma_adjugate = _resplit(before.inertia, before.direction, q)
        adjugate, adjugate_turned = _resplit(before.adjugate, before.direction, q)
        adjugate = _Split(adjugate.axial, adjugate.mixed, turned(adjugate_turned, q))
        one, nothing = builder.lift(1), builder.lift(0)
        projector = turned((one, nothing, nothing, one, nothing, one), q)
        trace_gamma = _trace(inertia.tangent)
        determinant = h * h + h * area * trace_gamma + area * area * adjugate.axial
        inverse = builder.let("inverse_pivot", 1 / determinant)
        solve = combine((h * inverse, projector), (area * inverse, gamma_adjugate))

        rate_squared = builder.let("rate_squared_k", dot(load(self.omega, k), load(self.omega, k)))
        bias_axial, bias_tangent = self._bias(before, q)
        lean = add(scale(area * rate_squared, inertia.mixed), scale(-length, bias_tangent))
        push = lean if self.couple is None else add(load(self.couple, k), lean)
        free = times(solve, push)
        slope = times(solve, scale(length, inertia.mixed))
        self.rate_squared[k] = rate_squared
        store(self.free, k, free)
        store(self.slope, k, slope)
        # D^-1 (m r P + l Gamma) as one matrix: D^-1 Gamma = (h Gamma + l^2 K_qq P) / det D
        mixed = combine((h, inertia.tangent), (area * adjugate.axial, projector))
        gain = combine((moment, solve), (length * inverse, mixed))
        for i in range(6):
            self.gain[6 * k + i] = gain[i]

        reach = add(scale(moment, free), scale(length, times(inertia.tangent, free)))
        axial = (inertia.axial * (h * h) + h * area * _trace(adjugate.tangent) + area * area * before.determinant) * inverse
        tangential = combine(
            (mass * h, gamma_adjugate), (h, adjugate.tangent),
            (area * (mass * adjugate.axial + before.determinant), projector),
        )  # fmt: skip
        return _Outer(
            direction=q,
            inertia=_Split(
                mass + axial, scale(-skew, times(solve, inertia.mixed)), combine((lever * inverse, mixed))
            ),
            adjugate=_Split(
                lever * lever * (adjugate.axial * inverse),
                scale(-(lever * skew) * inverse, adjugate.mixed),
                combine((lever * inverse, tangential)),
            ),
            determinant=lever * lever * ((mass * adjugate.axial + before.determinant) * inverse),
            bias_axial=bias_axial - rate_squared * (moment + length * inertia.axial) + length * dot(inertia.mixed, free),
            bias_tangent=add(add(bias_tangent, scale(-(length * rate_squared), inertia.mixed)), reach),
        )

    def _numbers(self, k: Index) -> list[Expr]:
        derived = self.parameters.derived
        mass, length, com = self.parameters.mass, self.parameters.length, self.parameters.com
        return [
            derived("inertia", lambda i: mass[i] * com[i] * com[i])[k],
            derived("moment", lambda i: mass[i] * com[i])[k],
            derived("skew", lambda i: mass[i] * com[i] * (length[i] - com[i]))[k],
            derived("lever", lambda i: mass[i] * (length[i] - com[i]) * (length[i] - com[i]))[k],
            length[k],
        ]

    def _bias(self, before: _Outer, q: Vector) -> tuple[Expr, Vector]:
        """The outer bias force split at q."""
        across = cross(q, before.direction)
        axial = before.bias_axial * dot(q, before.direction) + dot(q, before.bias_tangent)
        turned_bias = add(scale(before.bias_axial, across), cross(q, before.bias_tangent))
        return axial, cross(turned_bias, q)

    def close_on_cart(self, chain: _Outer, force: tuple[Expr, Expr]) -> tuple[Expr, Expr]:
        """(m_c I + A_hh) x'' = u - f_h + g A_hz, solved by cofactors; det A_hh is the vertical entry of K."""
        builder, parameters = self.builder, self.parameters
        q = chain.direction
        xx, xy, xz, yy, yz, _ = _joined(chain.inertia, q)
        bias = add(scale(chain.bias_axial, q), chain.bias_tangent)
        push_x = force[0] - bias[0] + parameters.gravity * xz
        push_y = force[1] - bias[1] + parameters.gravity * yz
        cart = parameters.cart_mass
        determinant = cart * cart + cart * (xx + yy) + _joined(chain.adjugate, q)[5]
        inverse = builder.let("inverse_cart_pivot", 1 / determinant)
        first = ((cart + yy) * push_x - xy * push_y) * inverse
        second = ((cart + xx) * push_y - xy * push_x) * inverse
        return builder.let("cart_acceleration_0", first), builder.let("cart_acceleration_1", second)

    def outwards(self, base: Vector, rates: ArrayRef) -> None:
        """t_k = free - slope (q.a) - gain a, omega_k' = q_k x t_k, and on to the next joint."""
        builder, parameters = self.builder, self.parameters
        with builder.loop("k", 0, parameters.links) as loop:
            k = loop.index
            joint = (loop.carry("joint_x", base[0]), loop.carry("joint_y", base[1]), loop.carry("joint_z", base[2]))
            q = load(self.direction, k)
            gain = [self.gain[6 * k + i] for i in range(6)]
            along = dot(q, joint)
            moved = times((gain[0], gain[1], gain[2], gain[3], gain[4], gain[5]), joint)
            tangent = add(load(self.free, k), scale(-1, add(scale(along, load(self.slope, k)), moved)))
            store(rates, k, cross(q, tangent))
            tip = add(joint, scale(parameters.length[k], add(tangent, scale(-self.rate_squared[k], q))))
            for before, after in zip(joint, tip, strict=True):
                loop.follow(before, after)


def _trace(matrix: Symmetric) -> Expr:
    return matrix[0] + matrix[3] + matrix[5]


def _resplit(split: _Split, old: Vector, new: Vector) -> tuple[_Split, Symmetric]:
    """Split a matrix that is split at `old` anew at `new`; also the tangent part turned by a right angle, its adjugate.

    Only cross products with `new` enter the tangent parts, so nothing small is left from a difference of large numbers.
    """
    across = cross(new, old)
    mixed_across = cross(new, split.mixed)
    tangent_turned = combine(
        (split.axial, outer(across)), (1, symmetric_outer(across, mixed_across)), (1, turned(split.tangent, new))
    )
    cosine = dot(new, old)
    pressed = times(split.tangent, new)
    lean = dot(new, split.mixed)
    axial = split.axial * (cosine * cosine) + 2 * (cosine * lean) + dot(new, pressed)
    turned_mixed = add(
        add(scale(split.axial * cosine + lean, across), scale(cosine, mixed_across)), cross(new, pressed)
    )
    return _Split(axial, cross(turned_mixed, new), turned(tangent_turned, new)), tangent_turned


def _joined(split: _Split, q: Vector) -> Symmetric:
    """The matrix itself in world components."""
    return combine((split.axial, outer(q)), (1, symmetric_outer(q, split.mixed)), (1, split.tangent))
