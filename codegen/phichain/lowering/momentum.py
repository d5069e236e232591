"""Generalised momenta p = dT/dv in O(N), without an inertia: velocities summed outwards, linear momenta summed inwards.

Mass k moves with r_k' = x' + sum_{j<k} l_j q_j' + r_k q_k', and P_k = sum_{a>=k} m_a r_a' is the momentum from link k on. Then

    p_x = m_0 x' + C^T P_1,       p_k = (dq_k'/d rate_k)^T (r_k P_k + (l_k - r_k) P_{k+1} + J_k q_k')

In the plane dq_k'/d phi_k' = (cos phi_k, -sin phi_k), and p_theta = S^T p_phi; rotors add A_k slip_k - A_{k+1} slip_{k+1} to p_phi,
slip_k the rate of joint k. In space q_k' = omega_k x q_k gives p_k = q_k x (r_k P_k + (l_k - r_k) P_{k+1} + J_k q_k'), which is
orthogonal to q_k: the gradient of T along the rates that are tangent. For tangent omega p is the matrix of (16) times v. No term of a
mass is subtracted but where a centre of mass is beyond its link's end, and masses at the links' ends have no second one.
"""

from __future__ import annotations

from collections.abc import Callable

from phichain.ir.builder import ArrayRef, Builder, Expr, Index
from phichain.lowering.algebra.vector import Vector, add, cross, dot, load, multiple, named, store, zeros
from phichain.lowering.chain.parameters import Parameters
from phichain.lowering.planar.functions import absolute_sincos
from phichain.lowering.planar.geared import terms as rotors
from phichain.lowering.planar.joints import absolute, to_generalised
from phichain.lowering.writers import writes
from phichain.scene import Scene

Turning = Callable[[Index], Vector]
Share = Callable[[Index, Expr, Vector, Expr, Vector], Vector]


@writes("momentum", space="planar")
def planar_momentum(
    builder: Builder, scene: Scene, parameters: Parameters, q: ArrayRef, v: ArrayRef, out: ArrayRef
) -> None:
    """[p_x, p_theta]; vectors are (along e_1, upwards), so that q_k' = phi_k' (cos phi_k, sin phi_k)."""
    offset = int(scene.has_cart)
    sine, cosine = absolute_sincos(builder, scene, q)
    rate, momenta = absolute(builder, scene, "rate", v.shifted(offset)), builder.array("absolute_momentum", scene.links)

    couple = rotors.couples(builder, scene, parameters, "rotor_momentum", v.shifted(offset))

    def along(k: Index) -> Vector:
        return cosine[k], sine[k]

    def share(k: Index, com: Expr, own: Vector, overhang: Expr, beyond: Vector) -> Vector:
        total = com * dot(along(k), own) + overhang * dot(along(k), beyond)
        if parameters.inertia is not None:
            total = total + parameters.inertia[k] * rate[k]
        return (rotors.added(total, couple, k),)

    (forwards, _) = _swept(builder, parameters, v, (offset, 2), lambda k: multiple(rate[k], along(k)), share, momenta)
    to_generalised(builder, scene, momenta, out.shifted(offset))
    if scene.has_cart:
        out[0] = parameters.cart_mass * v[0] + forwards


@writes("momentum", space="spatial")
def spatial_momentum(
    builder: Builder, scene: Scene, parameters: Parameters, q: ArrayRef, v: ArrayRef, out: ArrayRef
) -> None:
    """[p_x, p_1 .. p_N], p_k orthogonal to q_k."""
    offset = 2 if scene.has_cart else 0
    direction, omega = q.shifted(offset), v.shifted(offset)

    def turning(k: Index) -> Vector:
        return cross(load(omega, k, 3), load(direction, k, 3))

    def share(k: Index, com: Expr, own: Vector, overhang: Expr, beyond: Vector) -> Vector:
        share = add(multiple(com, own), multiple(overhang, beyond))
        if parameters.inertia is not None:
            share = add(share, multiple(parameters.inertia[k], turning(k)))
        return cross(load(direction, k, 3), share)

    whole = _swept(builder, parameters, v, (offset, 3), turning, share, out.shifted(offset))
    for i in range(offset):
        out[i] = parameters.cart_mass * v[i] + whole[i]


def _swept(
    builder: Builder, parameters: Parameters, v: ArrayRef, sizes: tuple[int, int], turning: Turning, share: Share,
    momenta: ArrayRef,
) -> Vector:  # fmt: skip
    """Write what each link's rate is conjugate to, and return the momentum of all masses.

    Args:
        builder: where the Program is recorded.
        parameters: the numbers of the chain.
        v: rates, those of the cart first.
        sizes: numbers of the cart's coordinates and of a vector's components.
        turning: q_k'.
        share: what r_k P_k + (l_k - r_k) P_{k+1} is for link k's rate.
        momenta: receives that.
    """
    cart, size = sizes
    axes, nothing = "xyz"[:size], zeros(builder, size)
    base = (*(v[i] for i in range(cart)), *nothing[cart:])
    own = builder.array("mass_momentum", size * parameters.links)
    mass, length, com = parameters.mass, parameters.length, parameters.com
    overhang = parameters.derived("length_beyond", lambda k: length[k] - com[k])
    with builder.loop("k", 0, parameters.links) as loop:
        k = loop.index
        speed = tuple(loop.carry(f"joint_speed_{axis}", start) for axis, start in zip(axes, base, strict=True))
        turn = named(builder, "turning", turning(k))
        at_mass = named(builder, "mass_speed", add(speed, multiple(com[k], turn)))
        store(own, k, multiple(mass[k], at_mass))
        for before, after in zip(speed, add(speed, multiple(length[k], turn)), strict=True):
            loop.follow(before, after)
    with builder.loop("k", parameters.links - 1, -1, -1) as loop:
        k = loop.index
        beyond = tuple(loop.carry(f"beyond_{axis}", start) for axis, start in zip(axes, nothing, strict=True))
        whole = named(builder, "momentum", add(beyond, load(own, k, size)))
        store(momenta, k, share(k, com[k], whole, overhang[k], beyond))
        for before, after in zip(beyond, whole, strict=True):
            loop.follow(before, after)
    return beyond
