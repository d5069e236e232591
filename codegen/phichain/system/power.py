"""What inputs give to a chain and what resists it takes, at one moment: the one place that knows the power of each law.

A new input or a new loss is one more term here; the books of every simulation follow.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from phichain.records import Held
from phichain.system.angles import absolute_angles
from phichain.system.arrays import Vector
from phichain.system.state import angular_velocities, unit_vectors, unpack
from phichain.system.system import Parameters, System


@dataclass(frozen=True, eq=False)
class Powers(Held):
    """Energy per time.

    Attributes:
        work: What the inputs do on the chain (m,), W.
        loss: What dampers and dry friction take from it (m,), W; never negative.
    """

    work: Vector
    loss: Vector


def powers(system: System, x: Vector, u: Vector, p: Parameters | None = None) -> Powers:
    """The powers of states (m, nx) under inputs (m, nu): dE/dt = work - loss along the motion.

    Args:
        system: The chain.
        x: States.
        u: Inputs: generalised forces of the entries of v that `system.drive` names, behind the accelerations of a base that is
            given them.
        p: Runtime parameters by name.
    """
    q, v = unpack(system, x)
    given = system.drive.accelerations
    work = np.sum(u[..., given:] * v[..., list(system.drive.coordinates)], axis=-1)
    loss = _of_joints(system, v, p) + _of_cart(system, v, p)
    if given and system.has_cart:
        # Whoever drives the cart also overcomes what resists it.
        work = work + _of_driven_cart(system, q, v, u, p) + _of_cart(system, v, p)
    elif given:
        work = work + _of_moving_base(system, q, v, u[..., :given], p)
    return Powers(work, loss)


def is_lossy(system: System) -> bool:
    """Whether something of the chain takes energy from it."""
    return system.joints.resists or system.numbers.brakes_cart


def joint_rates(system: System, v: Vector) -> Vector:
    """How fast neighbours turn against each other, rad/s: (m, N) in the plane, (m, N, 3) in space; the first against the base."""
    if system.is_planar:
        return np.diff(absolute_angles(system, v), axis=-1, prepend=0.0)
    return np.diff(angular_velocities(system, v), axis=-2, prepend=0.0)


def _of_joints(system: System, v: Vector, p: Parameters | None) -> Vector:
    """sum_k d_k |w_k|^2 + F_k |w_k| tanh(|w_k| / v_0), w_k = omega_k - omega_(k-1), theta_k' in the plane."""
    total = np.zeros(v.shape[:-1])
    if not system.joints.resists:
        return total
    rates = joint_rates(system, v)
    rates = np.abs(rates) if system.is_planar else np.linalg.norm(rates, axis=-1)
    if system.joints.damping is not None:
        total = total + np.sum(system.number("damping", p) * rates**2, axis=-1)
    if system.joints.friction is not None and system.joints.friction_speed:
        total = total + np.sum(system.number("friction", p) * rates * np.tanh(rates / system.joints.friction_speed), axis=-1)
    return total


def _of_cart(system: System, v: Vector, p: Parameters | None) -> Vector:
    """d_0 |x'|^2 + F_0 |x'| tanh(|x'| / v_0)."""
    total, speed = np.zeros(v.shape[:-1]), v[..., : system.cart_size]
    if system.numbers.cart_damping is not None:
        total = total + system.number("cart_damping", p) * np.sum(speed**2, axis=-1)
    if system.numbers.cart_friction is not None and system.numbers.cart_friction_speed:
        size = np.linalg.norm(speed, axis=-1)
        total = total + system.number("cart_friction", p) * size * np.tanh(size / system.numbers.cart_friction_speed)
    return total


def _first_moments(system: System, p: Parameters | None) -> tuple[Vector, float]:
    """mu_k (N,), kg m, and M_00, kg."""
    mass, length = (np.broadcast_to(system.number(name, p), system.links) for name in ("mass", "length"))
    com = np.broadcast_to(system.number("com", p, length), system.links)
    beyond = np.append(np.cumsum(mass[:0:-1])[::-1], 0.0)
    cart = 0.0 if system.numbers.cart_mass is None else float(system.number("cart_mass", p))
    return mass * com + length * beyond, float(np.sum(mass)) + cart


def _of_driven_cart(system: System, q: Vector, v: Vector, u: Vector, p: Parameters | None) -> Vector:
    """x'.(M_00 x'' + sum_k mu_k C^T q_k''), the power of the force that makes the cart go as it is told."""
    a = system.forward_dynamics(q, v, u, **system.parameters(p))
    moments, mass = _first_moments(system, p)
    cart = system.cart_size
    if system.is_planar:
        phi, rate, turning = (absolute_angles(system, part) for part in (q, v, a))
        sway = np.sum(moments * (np.cos(phi) * turning - np.sin(phi) * rate**2), axis=-1)[..., None]
    else:
        directions, omega, alpha = unit_vectors(system, q), angular_velocities(system, v), angular_velocities(system, a)
        bending = np.cross(alpha, directions) - np.sum(omega**2, axis=-1, keepdims=True) * directions
        sway = np.einsum("k,...ki->...i", moments, bending)[..., :cart]
    power: Vector = np.sum(v[..., :cart] * (mass * a[..., :cart] + sway), axis=-1)
    return power


def _of_moving_base(system: System, q: Vector, v: Vector, b: Vector, p: Parameters | None) -> Vector:
    """-b.sum_k mu_k q_k': seen from the base, the force of its acceleration acts on every mass."""
    moments, _ = _first_moments(system, p)
    if system.is_planar:
        phi, rate = absolute_angles(system, q), absolute_angles(system, v)
        swept = np.stack([np.cos(phi) * rate, -np.sin(phi) * rate], axis=-1)
    else:
        swept = np.cross(angular_velocities(system, v), unit_vectors(system, q))
    power: Vector = -np.einsum("...i,k,...ki->...", b, moments, swept[..., list(system.drive.axes)])
    return power
