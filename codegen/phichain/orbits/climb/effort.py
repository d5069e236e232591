"""What it takes to lead a chain from one orbit of a family to the next: the least torque that does it within a period.

Over one period T a torque u moves the chain by int Phi(T, t) B u dt, Phi the transition along the orbit. Across the orbit that is to be
d, from where the one brakes to where the other does; the torque of least square that does it has the mean square

    u^2 = d^T W^-1 d / T,    W = int Phi B B^T Phi^T dt,

all of them projected across the flow. W is the controllability Gramian of the motion across: where its least eigenvalue is small an
orbit is hardly left, however much energy the input brings in, for what it brings in goes elsewhere.

Source: R. E. Kalman, Y. C. Ho, K. S. Narendra, Controllability of linear dynamical systems, Contributions to Differential Equations 1
(1963) 189-213.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from phichain.orbits.climb.motion import Equations
from phichain.system import Vector

EVERY: Final = 4
"""States kept of a quarter from which one held torque lasts to the next."""
STEPS: Final = 4
"""Steps of integration meanwhile."""
WILD: Final = 1e6
"""Growth within a period beyond which a torque is not counted: there any orbit is left by next to nothing."""


def torques(equations: Equations, quarters: Vector, periods: Vector, weights: Vector) -> Vector:
    """Root mean squares of the torques from every orbit to the next (orbits - 1,), N m.

    Args:
        equations: The chain's motion.
        quarters: States from brake to bottom (orbits, m, nx), evenly spaced in time.
        periods: (orbits,), s.
        weights: Of the state's entries (nx,), in which the way across an orbit is square to its flow.
    """
    nx = quarters.shape[2]
    half = nx // 2
    mirror = np.concatenate([-np.ones(half), np.ones(half)])
    x = np.concatenate([quarters, quarters[:, -2::-1] * mirror], axis=1)[:-1, ::EVERY]
    count = x.shape[1] - 1
    moved, growth = _moved(equations, x, periods[:-1] / 2 / count)
    scale = np.sqrt(weights)
    flow = scale * equations.rate(x[:, 0])
    ways = scale * np.diff(quarters[:, 0], axis=0)
    found = np.zeros(len(x))
    for k in np.flatnonzero(growth < WILD):
        across = np.linalg.svd(np.eye(nx) - np.outer(flow[k], flow[k]) / (flow[k] @ flow[k]))[0][:, : nx - 1]
        reach = across.T @ (scale[:, None] * moved[k])
        u = np.linalg.lstsq(reach, across.T @ ways[k], rcond=1e-12)[0]
        found[k] = np.sqrt(np.mean(u**2))
    return found


def _moved(equations: Equations, x: Vector, h: Vector) -> tuple[Vector, Vector]:
    """Where torques held from state to state move the chain within a period (orbits, nx, 2 count), and how much that grows (orbits,).

    The second half of the period is the mirror image of the first: there a torque that is turned about does the same, turned about.
    """
    orbits, kept, nx = x.shape
    _, D = equations.carried(x[:, :-1].reshape(-1, nx), np.repeat(h, kept - 1), STEPS)
    D = D.reshape(orbits, kept - 1, nx, nx + 1)
    ahead, by_half = np.tile(np.eye(nx), (orbits, 1, 1)), np.zeros((orbits, nx, kept - 1))
    for i in range(kept - 2, -1, -1):
        by_half[:, :, i] = -(ahead @ D[:, i, :, nx:])[..., 0]
        ahead = ahead @ D[:, i, :, :nx]
    return np.concatenate([-ahead @ by_half, by_half], axis=2), np.linalg.norm(ahead, 2, axis=(1, 2)) ** 2
