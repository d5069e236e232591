"""Starts at rest around an equilibrium, along rays of the links' turns.

In space xi_i = s_i e_3 x q_i as in (19), whatever its size: |xi_i| is the sine of the link's tilt, and a ray ends where its first
link is level. In the plane xi_i is the change of the link's direction, rad.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np

from phichain.system import System, Vector
from phichain.system.angles import scene_angles
from phichain.system.vertical import Signs


class Flown(Protocol):
    """A closed loop: `native.closed_loop` has the compiled one."""

    @property
    def period(self) -> float: ...

    def __call__(self, which: int, x: Vector, calls: int, near: float, far: float) -> tuple[Vector, Vector]: ...


def directions(system: System, count: int, seed: int) -> Vector:
    """Unit vectors (count, k) evenly spread over all directions of the links' turns; two of them are all that one link in the plane has."""
    size = system.links * (1 if system.is_planar else 2)
    if size == 1:
        return np.array([[1.0], [-1.0]])
    drawn = np.random.default_rng(seed).normal(size=(count, size))
    return np.asarray(drawn / np.linalg.norm(drawn, axis=1, keepdims=True))


def turn_names(system: System) -> tuple[str, ...]:
    """Names of the links' turns (k,)."""
    if system.is_planar:
        return tuple(f"xi_{i + 1}" for i in range(system.links))
    return tuple(f"xi_{i + 1}_{axis}" for i in range(system.links) for axis in (1, 2))


def turned(system: System, s: Signs, xi: Vector) -> Vector:
    """States at rest (count, nx) with links turned by xi (count, k) from the equilibrium s, the cart at the origin; in space where the ray ends at most."""
    signs = np.array(s, dtype=float)
    x = np.zeros((len(xi), system.nx))
    if system.is_planar:
        x[:, system.cart_size : system.nq] = scene_angles(system, np.where(signs > 0, 0.0, np.pi) + xi)
        return x
    axes = xi.reshape(len(xi), system.links, 2)
    axes = axes / np.maximum(1.0, np.max(np.linalg.norm(axes, axis=2), axis=1))[:, None, None]
    upright = np.sqrt(np.maximum(0.0, 1 - np.sum(axes**2, axis=2)))
    q = np.stack([signs * axes[..., 1], -signs * axes[..., 0], signs * upright], axis=-1)
    x[:, system.cart_size : system.nq] = q.reshape(len(xi), -1)
    return x
