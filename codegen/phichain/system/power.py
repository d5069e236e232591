"""What inputs give to a chain and what its joints take from it, at one moment: the one place that knows the power of each law.

A new input or a new loss is one more term here; the books of every simulation follow.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from phichain.records import Held
from phichain.system.angles import absolute_angles
from phichain.system.arrays import Vector
from phichain.system.state import angular_velocities, unpack
from phichain.system.system import Parameters, System


@dataclass(frozen=True, eq=False)
class Powers(Held):
    """Energy per time.

    Attributes:
        work: What the inputs do on the chain (m,), W.
        loss: What dampers take from it (m,), W; never negative.
    """

    work: Vector
    loss: Vector


def powers(system: System, x: Vector, u: Vector, p: Parameters | None = None) -> Powers:
    """The powers of states (m, nx) under inputs (m, nu): dE/dt = work - loss along the motion.

    Args:
        system: The chain.
        x: States.
        u: Inputs, generalised forces of the entries of v that `system.drive` names.
        p: Runtime parameters by name.
    """
    _, v = unpack(system, x)
    work = np.sum(u * v[..., list(system.drive.coordinates)], axis=-1)
    return Powers(work, _damped(system, v, p))


def is_lossy(system: System) -> bool:
    """Whether something of the chain takes energy from it."""
    return system.joints.damping is not None


def joint_rates(system: System, v: Vector) -> Vector:
    """How fast neighbours turn against each other, rad/s: (m, N) in the plane, (m, N, 3) in space; the first against the base."""
    if system.is_planar:
        return np.diff(absolute_angles(system, v), axis=-1, prepend=0.0)
    return np.diff(angular_velocities(system, v), axis=-2, prepend=0.0)


def _damped(system: System, v: Vector, p: Parameters | None) -> Vector:
    """sum_k d_k |omega_k - omega_(k-1)|^2, theta_k' in the plane."""
    if system.joints.damping is None:
        return np.zeros(v.shape[:-1])
    rates = joint_rates(system, v) ** 2
    squares = rates if system.is_planar else np.sum(rates, axis=-1)
    loss: Vector = np.sum(system.number("damping", p) * squares, axis=-1)
    return loss
