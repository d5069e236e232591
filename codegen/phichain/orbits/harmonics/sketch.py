"""A first guess of a brake orbit's harmonics where none is near: the quarter period itself, roughly integrated and transformed."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from scipy.integrate import solve_ivp

from phichain.orbits.harmonics.basis import basis
from phichain.system import Parameters, System, Vector, acceleration

_ROUGH: Final = 1e-8


def sketched(system: System, p: Parameters | None, z: Vector, highest: int) -> Vector | None:
    """The harmonics 3, 5, .. (M - 1, n) of the motion that starts at rest at q_0; None where it cannot be followed.

    Args:
        system: A chain with `forward_dynamics`.
        p: Runtime parameters.
        z: (q_0, omega).
        highest: The highest harmonic.
    """
    table, n, omega = basis("odd cosines", highest), len(z) - 1, float(z[-1])

    def field(_: float, x: Vector) -> Vector:
        return np.concatenate([x[n:], acceleration(system, x[:n], x[n:], None, p)])

    found: Any = solve_ivp(
        field, (0.0, np.pi / 2 / omega), np.concatenate([z[:-1], np.zeros(n)]), "DOP853", table.phase / omega, rtol=_ROUGH, atol=_ROUGH
    )
    return table.project[1:] @ found.y[:n].T if found.success else None
