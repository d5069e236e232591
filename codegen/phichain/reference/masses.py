"""The chain's mechanics from positions: sums along the chain and d'Alembert's principle, nothing clever.

This is the ground the reference stands on. It shares no formula with the lowered programs: no mu_k, no c_ij,
no tension, no sweep. Every quantity comes from the positions r_a of the point masses (theory section 1)

    r_a = C x + sum_{k<a} l_k q_k + com_a q_a,

their Jacobians J_a with respect to the rates, and sum_a J_a^T m_a (r_a'' - g e_d) = generalised force. A link's moment of inertia
about its centre of mass is that of two halves of its mass sqrt(J/m) before and behind it: what they move with beside the centre is
+-sqrt(J/m) q_k, so that J_k weighs q_k as m_a weighs r_a, and gravity pulls on neither. No J_a is written out: J_a times rates is a sum from the base outwards, sum_a J_a^T times forces one from the tip inwards, so that each
quantity costs O(N). Vectors of all masses are stacked, N times d entries, and those of the links behind them where these have inertia.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from mpmath import fdot, mp, mpf

from phichain.reference.algebra import Matrix, Vector, dot, unit
from phichain.reference.pose import Parameters, Pose, absolute, cart_axes, pulled_back
from phichain.scene import Scene


def stacked(values: Parameters, links: Matrix, base: Sequence[object] = ()) -> Vector:
    """Return base + sum_k lever_ak w_k for every mass a, for one vector w_k per link; lever_ak is l_k, com_a at k = a, 0 beyond."""
    size = len(links[0])
    inner: Vector = [*base, *[mpf(0)] * (size - len(base))]
    masses: Vector = []
    for length, com, link in zip(values.length, values.com, links, strict=True):
        masses += [a + com * b for a, b in zip(inner, link, strict=True)]
        inner = [a + length * b for a, b in zip(inner, link, strict=True)]
    return masses + [entry for _, link in zip(values.inertia, links, strict=False) for entry in link]


def gathered(values: Parameters, forces: Vector, size: int) -> tuple[Vector, Matrix]:
    """Return sum_a F_a, and sum_a lever_ak F_a for every link k, for stacked forces F_a in R^size: the transpose of `stacked`."""
    beyond: Vector = [mpf(0)] * size
    links: Matrix = []
    for k in reversed(range(len(values.mass))):
        own = forces[size * k : size * (k + 1)]
        length, com = values.length[k], values.com[k]
        links.append([com * a + length * b for a, b in zip(own, beyond, strict=True)])
        if values.inertia:
            turning = forces[size * (len(values.mass) + k) :]
            links[-1] = [a + b for a, b in zip(links[-1], turning, strict=False)]
        beyond = [a + b for a, b in zip(own, beyond, strict=True)]
    return beyond, links[::-1]


def driven(scene: Scene, values: Parameters, pose: Pose, rates: Vector) -> Vector:
    """Return J rates, stacked: how the masses move at those rates of the cart and the links (planar: of the scene's own angles)."""
    carts = cart_axes(scene)
    own = absolute(scene, rates[carts:]) if scene.is_planar else rates[carts:]
    return stacked(values, turned(pose, own), rates[:carts])


def turned(pose: Pose, own: Vector) -> Matrix:
    """Return how every link's vector moves at the links' own rates."""
    return _combined(pose.turning, own)


def spun(pose: Pose, own: Vector) -> Matrix:
    """Return every link's angular velocity at its own rates."""
    return _combined(pose.axes, own)


def _combined(bases: Sequence[Matrix], own: Vector) -> Matrix:
    rates, found = iter(own), []
    for first, *others in bases:
        rate = next(rates)
        vector = [rate * entry for entry in first]
        for axis in others:
            rate = next(rates)
            vector = [a + rate * b for a, b in zip(vector, axis, strict=True)]
        found.append(vector)
    return found


def conjugate(scene: Scene, values: Parameters, pose: Pose, acceleration: Vector) -> Vector:
    """Return sum_a J_a^T m_a r_a'' for stacked accelerations r_a'' (m/s^2)."""
    whole, links = gathered(values, weighted(values, acceleration), len(pose.direction[0]))
    force = [fdot(turn, arm) for turning, arm in zip(pose.turning, links, strict=True) for turn in turning]
    return whole[: cart_axes(scene)] + (pulled_back(scene, force) if scene.is_planar else force)


def weighted(values: Parameters, column: Vector) -> Vector:
    """Return the entries of stacked vectors times their mass m_a, or the inertia of their link."""
    weights = [*values.mass, *values.inertia]
    size = len(column) // len(weights)
    return [weights[i // size] * entry for i, entry in enumerate(column)]


def centripetal(values: Parameters, pose: Pose) -> Vector:
    """Return r_a'' at vanishing rates' rates, stacked (m/s^2): -sum_k lever_ak |q_k'|^2 q_k."""
    inward = [
        [-dot(rate, rate) * entry for entry in link]
        for rate, link in zip(pose.rate, pose.direction, strict=True)
    ]
    return stacked(values, inward)


def anti_gravity(values: Parameters, pose: Pose, base: Sequence[object] = ()) -> Vector:
    """Return -g e_d for every mass, stacked (m/s^2), and what its base accelerates it by."""
    size = len(pose.direction[0])
    rise = [-values.gravity * entry for entry in unit(size, size - 1)]
    fall = ([a + b for a, b in zip(rise, base, strict=True)] if base else rise) * len(values.mass)
    return fall + [mpf(0)] * (size * len(values.inertia))


def joint_force(scene: Scene, values: Parameters, pose: Pose) -> Vector:
    """Return the generalised force of springs, dampers and dry friction (N m; N for the cart).

    Joint k loads its outer link with -k_k bend_k - d_k (spin_k - spin_{k-1}) and its inner one with the
    opposite, bend_k less the angle at which the spring rests; dry friction of F against a rate w is -F tanh(|w| / v_0) w / |w|.
    """
    zero = [mpf(0)] * len(pose.spin[0])
    moments = []
    for k, (bend, spin, before) in enumerate(zip(pose.bend, pose.spin, [zero, *pose.spin], strict=False)):
        slips = [outer - inner for outer, inner in zip(spin, before, strict=True)]
        bends = [angle - values.rest_angle[k] for angle in bend]
        dry = _dry(values.friction[k], values.friction_speed, slips)
        laws = zip(bends, slips, dry, strict=True)
        moments.append([-values.stiffness[k] * angle - values.damping[k] * slip - rub for angle, slip, rub in laws])
    couples = [
        [own - beyond for own, beyond in zip(moment, after, strict=True)]
        for moment, after in zip(moments, [*moments[1:], zero], strict=True)
    ]
    force = [dot(axis, couple) for own, couple in zip(pose.axes, couples, strict=True) for axis in own]
    return cart_force(values, pose) + (pulled_back(scene, force) if scene.is_planar else force)


def cart_force(values: Parameters, pose: Pose) -> Vector:
    """Return the force of damper and dry friction on the cart, by its directions (N)."""
    rubs = _dry(values.cart_friction, values.cart_friction_speed, pose.cart_rate)
    return [-values.cart_damping * rate - rub for rate, rub in zip(pose.cart_rate, rubs, strict=True)]


def _dry(force: Any, speed: Any, rate: Vector) -> Vector:
    """F tanh(|w| / v_0) w / |w|, in the plane F tanh(w / v_0)."""
    if not force or not any(rate):
        return [mpf(0)] * len(rate)
    size = mp.sqrt(dot(rate, rate))
    return [force * mp.tanh(size / speed) * entry / size for entry in rate]


def rotor_momentum(scene: Scene, values: Parameters, rates: Vector) -> Vector:
    """Return the derivatives of sum 1/2 A_k (relative rate of joint k)^2 by the rates (planar: of the scene's own angles)."""
    force = [mpf(0)] * len(rates)
    if not any(values.armature):
        return force
    carts, zero = cart_axes(scene), mpf(0)
    own = absolute(scene, rates[carts:])
    moments = [a * (w - before) for a, w, before in zip(values.armature, own, [zero, *own], strict=False)]
    couples = [moment - after for moment, after in zip(moments, [*moments[1:], zero], strict=True)]
    return force[:carts] + pulled_back(scene, couples)


def push(scene: Scene, inputs: Sequence[object]) -> Vector:
    """Return B u: the forces among the inputs as generalised ones."""
    force: Vector = [mpf(0)] * rate_count(scene)
    for target, entry in zip(_driven_rates(scene), inputs[scene.base_accelerations :], strict=True):
        force[target] = entry
    return force


def input_matrix(scene: Scene) -> Matrix:
    """Return B: the force on the cart's axes, then the scene's own angles that are actuated; nothing of accelerations."""
    targets = _driven_rates(scene)
    return [[mpf(int(row == target)) for target in targets] for row in range(rate_count(scene))]


def rate_count(scene: Scene) -> int:
    """Return the number of independent rates: the cart's, then one a link in the plane and two in space."""
    return cart_axes(scene) + scene.links * (1 if scene.is_planar else 2)


def _driven_rates(scene: Scene) -> list[int]:
    carts = cart_axes(scene)
    return (list(range(carts)) if scene.has_force and not scene.is_driven else []) + [carts + joint - 1 for joint in scene.actuated_joints]
