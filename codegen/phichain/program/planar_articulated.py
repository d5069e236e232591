"""Planar forward dynamics with masses anywhere on their links, theory section 5: an articulated sweep in link frames.

Frames have x along the link and y along its tangent and are turned from joint to joint by the joint's angle. The force
that the chain beyond a joint asks for is A a + b, a the joint's acceleration minus gravity. The inertia A = [X Z; Z Y] is
kept free of cancellation through its determinant E. With A, E, b of the chain beyond link k in the frame of link k, w the
absolute rate and tau = tau_phi,k:

    D = m r^2 + l^2 A_yy,   X = m + (A_xx m r^2 + l^2 E) / D,   Z = -A_xy m r (l - r) / D,   Y = m A_yy (l - r)^2 / D
    E' = m (l - r)^2 (m A_yy + E) / D,   U_x = l A_xy,   U_y = m r + l A_yy,   p = tau - l (b_y - l w^2 A_xy)
    b'_x = b_x - (m r + l A_xx) w^2 + U_x p / D,   b'_y = b_y - l A_xy w^2 + U_y p / D

and outwards phi'' = (p - U_x a_x - U_y a_y) / D. On a cart the base closes with (m_c + A_yy) x'' = u - b_y + g A_xy.
"""

from __future__ import annotations

from dataclasses import dataclass

from phichain.program.builder import ArrayRef, Builder, Expr, Index
from phichain.program.parameters import Parameters
from phichain.program.planar_joints import PlanarState, couples, from_absolute
from phichain.scene import Scene


@dataclass(frozen=True)
class _Outer:
    """Articulated inertia and bias force of the chain beyond a joint, in the frame of the link before it."""

    xx: Expr
    xy: Expr
    yy: Expr
    determinant: Expr
    bias_x: Expr
    bias_y: Expr

    def scalars(self) -> dict[str, Expr]:
        """The six scalars by name, for the loop to carry."""
        return {f"{name}": getattr(self, name) for name in self.__dataclass_fields__}


@dataclass(frozen=True)
class _Gains:
    """phi''_k = free - gain_x a_x - gain_y a_y, and the centripetal rate w^2, stored for the outward sweep."""

    free: ArrayRef
    gain_x: ArrayRef
    gain_y: ArrayRef
    rate_squared: ArrayRef


def accelerations(
    builder: Builder, scene: Scene, parameters: Parameters, state: PlanarState, u: ArrayRef | None, a: ArrayRef
) -> None:
    """Write the accelerations [x'', theta''] into `a`."""
    links = scene.links
    sine, cosine = builder.sincos(state.angle, links)
    couple = couples(builder, scene, parameters, state, u)
    gains = _Gains(*(builder.array(name, links) for name in ("free", "gain_x", "gain_y", "rate_squared")))
    nothing = builder.lift(0)
    outer = _Outer(nothing, nothing, nothing, nothing, nothing, nothing)
    with builder.loop("k", links - 1, -1, -1) as loop:
        k = loop.index
        carried = _Outer(**{name: loop.carry(f"outer_{name}", value) for name, value in outer.scalars().items()})
        link = _inwards(builder, parameters, carried, k, couple, state, gains)
        turned = _turn(builder, link, sine[k], cosine[k])
        for name, value in turned.scalars().items():
            loop.follow(getattr(carried, name), value)
    base_x, base_y = -parameters.gravity, nothing
    if scene.has_cart:
        force = u[0] / parameters.units.force if u is not None and scene.has_force else nothing
        push = force + parameters.gravity * carried.xy - carried.bias_y
        base_y = builder.let("cart_acceleration", push / (parameters.cart_mass + carried.yy))
        a[0] = base_y * parameters.units.length
    alpha = builder.array("acceleration", links)
    with builder.loop("k", 0, links) as loop:
        k = loop.index
        before_x, before_y = loop.carry("base_x", base_x), loop.carry("base_y", base_y)
        joint_x = builder.let("joint_x", cosine[k] * before_x + sine[k] * before_y)
        joint_y = builder.let("joint_y", cosine[k] * before_y - sine[k] * before_x)
        alpha[k] = value = builder.let(
            "alpha", gains.free[k] - gains.gain_x[k] * joint_x - gains.gain_y[k] * joint_y
        )
        loop.follow(before_x, joint_x - parameters.length[k] * gains.rate_squared[k])
        loop.follow(before_y, joint_y + parameters.length[k] * value)
    from_absolute(builder, scene, alpha, a.shifted(int(scene.has_cart)))


def _inwards(
    builder: Builder, parameters: Parameters, outer: _Outer, k: Index, couple: ArrayRef | None,
    state: PlanarState, gains: _Gains,
) -> _Outer:  # fmt: skip
    """Articulated inertia and bias of link k and all beyond it, at its base joint, in its own frame."""
    let, derived = builder.let, parameters.derived
    mass, length, com = parameters.mass, parameters.length, parameters.com
    moment = derived("moment", lambda i: mass[i] * com[i])[k]
    inertia = derived("inertia", lambda i: mass[i] * com[i] * com[i])[k]
    length_squared = derived("length_squared", lambda i: length[i] * length[i])[k]
    lever = derived("lever", lambda i: mass[i] * (length[i] - com[i]) * (length[i] - com[i]))[k]
    skew = derived("skew", lambda i: mass[i] * com[i] * (length[i] - com[i]))[k]

    rate_squared = let("rate_squared_k", state.rate[k] * state.rate[k])
    inverse_pivot = let("inverse_pivot", 1 / (inertia + length_squared * outer.yy))
    tangential = let("tangential", outer.bias_y - length[k] * rate_squared * outer.xy)
    push = -(length[k] * tangential)
    if couple is not None:
        push = couple[k] - length[k] * tangential
    free = let("free_k", push * inverse_pivot)
    reach_x = let("reach_x", length[k] * outer.xy)
    reach_y = let("reach_y", moment + length[k] * outer.yy)

    gains.rate_squared[k] = rate_squared
    gains.free[k] = free
    gains.gain_x[k] = reach_x * inverse_pivot
    gains.gain_y[k] = reach_y * inverse_pivot

    along = let("along", outer.xx * inertia + length_squared * outer.determinant)
    across = let("across", lever * (outer.yy * inverse_pivot))
    return _Outer(
        xx=let("link_xx", mass[k] + along * inverse_pivot),
        xy=let("link_xy", -(skew * (outer.xy * inverse_pivot))),
        yy=across,
        determinant=let("link_determinant", mass[k] * across + lever * (outer.determinant * inverse_pivot)),
        bias_x=let("link_bias_x", outer.bias_x - (moment + length[k] * outer.xx) * rate_squared + reach_x * free),
        bias_y=let("link_bias_y", tangential + reach_y * free),
    )


def _turn(builder: Builder, link: _Outer, sine: Expr, cosine: Expr) -> _Outer:
    """The same inertia and bias in the frame of the link before (the determinant does not change)."""
    let = builder.let
    shear = let("shear", sine * (link.xx - link.yy) + cosine * (link.xy + link.xy))
    lean = let("lean", sine * shear)
    return _Outer(
        xx=let("turned_xx", link.xx - lean),
        xy=let("turned_xy", cosine * shear - link.xy),
        yy=let("turned_yy", link.yy + lean),
        determinant=link.determinant,
        bias_x=let("turned_bias_x", cosine * link.bias_x - sine * link.bias_y),
        bias_y=let("turned_bias_y", sine * link.bias_x + cosine * link.bias_y),
    )
