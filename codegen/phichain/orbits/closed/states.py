"""What orbits need of a state: its field, its energy, and how the energy changes beside it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from phichain.system import Parameters, System, Vector, acceleration


def field(system: System, p: Parameters | None, q: Vector, v: Vector) -> Vector:
    """(q', v') (2 nq,)."""
    return np.concatenate([v, acceleration(system, q, v, None, p)])


def energy_of(system: System, p: Parameters | None = None) -> Callable[[Vector, Vector], float] | None:
    """(q, v) -> energy, J, counted from the hanging rest; None without an energy callable."""
    if not system.has("energy"):
        return None
    n, parameters = system.nq, system.parameters(p)
    bottom = float(sum(system.energy(np.zeros(n), np.zeros(n), **parameters)))
    return lambda q, v: float(sum(system.energy(q, v, **parameters))) - bottom


def gradient(flow: Vector) -> Vector:
    """The energy's derivative -J f (2 N,) in canonical coordinates, of the flow f there."""
    links = len(flow) // 2
    return np.concatenate([-flow[links:], flow[:links]])


def unit(vector: Vector) -> Vector:
    """A vector at length one; zero stays zero."""
    size = float(np.linalg.norm(vector))
    return vector / size if size > 0 else vector
