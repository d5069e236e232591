"""Planar angles of a System: phi = S theta, for the kind of angles it has (docs/theory.md, 2)."""

from __future__ import annotations

import numpy as np

from phichain.system import System, Vector


def absolute_angles(system: System, q: Vector) -> Vector:
    """phi (..., N), rad, from a configuration or its rate (..., nq)."""
    theta = np.asarray(q)[..., system.cart_size :]
    if system.angles == "absolute":
        return theta
    if system.angles == "relative":
        return np.cumsum(theta, axis=-1)
    phi = theta.copy()
    phi[..., 1:] += theta[..., :-1]
    return phi


def scene_angles(system: System, phi: Vector) -> Vector:
    """theta (..., N) from the angles phi (..., N) of the links from the hanging vertical, rad."""
    if system.angles == "absolute":
        return phi
    theta = phi.copy()
    if system.angles == "relative":
        theta[..., 1:] -= phi[..., :-1]
        return theta
    for k in range(1, phi.shape[-1]):
        theta[..., k] -= theta[..., k - 1]
    return theta
