"""How far a spatial path has left its manifold, and the way back: unit q_k, omega_k . q_k = 0."""

from __future__ import annotations

import numpy as np

from phichain.system import System, Vector, angular_velocities, unit_vectors


def violations(system: System, q: Vector, v: Vector) -> tuple[Vector | None, Vector | None]:
    """|q_k| - 1 and omega_k . q_k (rad/s), each (m, N); (None, None) in the plane."""
    if system.is_planar:
        return None, None
    directions, rates = unit_vectors(system, q), angular_velocities(system, v)
    return np.linalg.norm(directions, axis=-1) - 1, np.sum(directions * rates, axis=-1)


def project_state(system: System, q: Vector, v: Vector) -> tuple[Vector, Vector]:
    """Nearest configuration with unit q_k, and v with the part of omega_k along q_k removed; shapes kept."""
    directions, rates = unit_vectors(system, q), angular_velocities(system, v)
    directions = directions / np.linalg.norm(directions, axis=-1, keepdims=True)
    rates = rates - np.sum(directions * rates, axis=-1, keepdims=True) * directions
    q_out, v_out = q.copy(), v.copy()
    q_out[..., system.cart_size :] = directions.reshape(*q.shape[:-1], 3 * system.links)
    v_out[..., system.cart_size :] = rates.reshape(*v.shape[:-1], 3 * system.links)
    return q_out, v_out
