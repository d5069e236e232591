"""Where the links of a System are in space, for drawing: joints as points, from a state and the scene's lengths."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from phichain.system import System, unit_vectors
from phichain.system.angles import absolute_angles

Points = NDArray[np.float64]


def link_lengths(system: System) -> Points:
    """Lengths l_1 .. l_N in metres, shape (N,), from the scene or else from the default runtime parameters.

    Raises:
        ArrayError: They are runtime parameters and the system has no default values, or it has none.
    """
    lengths: Points = system.number("length")
    return lengths


def directions(system: System, q: ArrayLike) -> Points:
    """Unit vectors along the links, shape (..., N, d); the last axis of space points along gravity."""
    if not system.is_planar:
        return unit_vectors(system, np.asarray(q, dtype=float))
    phi = absolute_angles(system, np.asarray(q, dtype=float))
    return np.stack([np.sin(phi), np.cos(phi)], axis=-1)


def joints(system: System, q: ArrayLike) -> Points:
    """Points from the base to the tip in metres, shape (..., N + 1, d)."""
    state = np.asarray(q, dtype=float)
    steps = link_lengths(system)[:, None] * directions(system, state)
    base = np.zeros((*steps.shape[:-2], 1, steps.shape[-1]))
    if system.has_cart:
        base[..., 0, :-1] = state[..., : system.cart_size]
    return np.concatenate([base, base + np.cumsum(steps, axis=-2)], axis=-2)


def tilt(system: System, q: ArrayLike) -> Points:
    """Angle of every link from the hanging vertical in radians, shape (..., N): 0 hangs, pi stands.

    Planar angles keep their sign and their turns; a spatial link has no sign, and its angle is taken from both sine
    and cosine, so that it is right near 0 and pi too.
    """
    if system.is_planar:
        return absolute_angles(system, np.asarray(q, dtype=float))
    unit = directions(system, q)
    return np.arctan2(np.hypot(unit[..., 0], unit[..., 1]), unit[..., 2])
