"""Alternating frequency-time: the balance of all harmonics from the equations of motion at the samples of a period.

With q(tau) = sum_m X_m c_m(tau), q' = omega dq/dtau, q'' = omega^2 d2q/dtau2 and u(q, q', q'') the emitted inverse dynamics,

    R_m = <c_m, u> - F_m,   dR_m/dX_l = <c_m, u_q c_l + omega u_v c_l' + omega^2 u_a c_l''>,   F the forcing's coefficients,

< , > the projection on the basis. Nothing is expanded in harmonics: the derivatives u_q, u_v, u_a are emitted, too, and exact.

Source: T. M. Cameron and J. H. Griffin, An alternating frequency/time domain method, J. Appl. Mech. 56 (1989) 149-154.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from phichain.orbits.harmonics.basis import Basis
from phichain.system import Parameters, System, Vector

NEEDED = ("inverse_and_jacobian",)
"""Functions that the balance calls."""
Inverse = Callable[[Vector, Vector, Vector], tuple[Vector, Vector, Vector, Vector]]
"""q, v, a (K, n) -> the generalised force (K, n) and its derivatives by them (K, n, n)."""


class Balanced(NamedTuple):
    """Residual (M, n) and its derivatives by the coefficients (M, n, M, n) and by omega (M, n)."""

    residual: Vector
    jacobian: Vector
    by_omega: Vector


def inverse_of(system: System, p: Parameters | None = None) -> Inverse:
    """The emitted inverse dynamics with its derivatives, the runtime parameters bound.

    Raises:
        AbsentFunctionError: The system lacks it.
    """
    function, parameters = system.function(NEEDED[0]), system.parameters(p)
    return lambda q, v, a: function(q, v, a, **parameters)


def balanced(inverse: Inverse, basis: Basis, coefficients: Vector, omega: float) -> Balanced:
    """The balance of a series without forcing.

    Args:
        inverse: The equations of motion.
        basis: Functions of the phase.
        coefficients: X (M, n).
        omega: Frequency of the phase, rad/s.
    """
    v, a = omega * (basis.slope @ coefficients), omega**2 * (basis.bend @ coefficients)
    u, by_q, by_v, by_a = inverse(basis.value @ coefficients, v, a)
    count, n = u.shape
    moved = (
        by_q[:, :, None, :] * basis.value[:, None, :, None]
        + (omega * by_v)[:, :, None, :] * basis.slope[:, None, :, None]
        + (omega**2 * by_a)[:, :, None, :] * basis.bend[:, None, :, None]
    )
    faster = (by_v @ v[:, :, None] + 2 * (by_a @ a[:, :, None]))[:, :, 0] / omega
    jacobian = (basis.project @ moved.reshape(count, -1)).reshape(basis.size, n, basis.size, n)
    return Balanced(basis.project @ u, jacobian, basis.project @ faster)
