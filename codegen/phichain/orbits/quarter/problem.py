"""Brake orbits by shooting over a quarter period: theta(0) = theta_0 at rest, theta(T/4) = 0.

The hanging chain is symmetric under theta -> -theta and under reversal of time, so a motion that starts at rest and hangs straight
after a quarter period is periodic: theta(t + T/2) = -theta(t). One propagation of the variational equations beside it,

    dq(T/4) = A dq_0 + B dv_0,   dv(T/4) = C dq_0 + D dv_0,

gives the Jacobian of the residual and, in the canonical coordinates L^T q and L^(-1) p with M = L L^T at either end,

    a = L_1^T A L_0^-T,   b = L_1^T B L_0^-T,   c = L_1^T C L_0^-T,   d = L_1^T D L_0^-T

(dM = 0 where the chain hangs straight, and v_0 = 0), the stability of the orbit: the half map P = -M(T/2), reduced by the symmetries,
is R Q^-1 R Q with Q = [a b; c d] symplectic and R = diag(-1, 1), so that its upper left block is 2 d^T a - 1 and

    kappa = (mu + 1/mu) / 2 = eig(1 - 2 d^T a),   lambda = mu^2:

multipliers pair by construction. The flow itself has kappa = 1, its left vector dV(q_0), and is split off; a cart's free translation
is taken out by its momentum, which is zero.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from phichain.continuation import Point, Problem
from phichain.continuation.linear import bordered, solve
from phichain.errors import UnsupportedError
from phichain.orbits.quarter.compiled import Braking, frequency_error_of
from phichain.orbits.single_harmonic import energy_of_amplitude
from phichain.system import Parameters, System, Vector

EPS = float(np.finfo(float).eps)
_TOLERANCE = 256 * EPS
"""That of the flow, which aims 2^8 below it in every step: at rounding."""
_ROUGH = 1e-9
"""The same far from an orbit, where columns need not be better than the next correction."""
_STEPS = 20_000
"""Steps of a quarter period that are worth taking: where Newton asks for more it has gone astray."""


def quarter_problem(system: System, p: Parameters | None = None, *, omega: float, shape: Vector, tol: float = _TOLERANCE) -> Problem:
    """theta(T/4; q_0) = 0 as a continuation problem with unknowns (q_0, omega), T = 2 pi / omega.

    A cart starts where its centre of mass is above the place at which the chain hangs straight: x(T/4) = 0.

    Args:
        system: A planar, undamped system whose `propagate` carries derivatives along, with `mass_matrix`.
        p: Runtime parameters.
        omega: Frequency of the linear mode, rad/s: its size.
        shape: Shape of the mode (nq,); a cart counts in units of its share.
        tol: Tolerance of the flow.

    Raises:
        AbsentFunctionError: A function is missing.
        UnsupportedError: The flow is none that was compiled.
    """
    flow, carts, nq = system.function("propagate"), system.cart_size, system.nq
    system.function("mass_matrix")
    if not hasattr(flow, "brake"):
        raise UnsupportedError(
            "propagate", system.name, "has no brake orbits compiled in", "build the scene with [flow] variational = true, or load its folder"
        )
    sizes = np.abs(np.concatenate([shape[:carts], np.ones(nq - carts), [omega]]))
    scale = powers(np.where(sizes > 0, sizes, 1.0))
    braking = Braking(flow.brake(scale, tol, _ROUGH, _STEPS, **system.parameters(p)))
    return Problem(
        evaluate=braking.evaluate,
        names=(*(system.q_names or tuple(f"q_{k + 1}" for k in range(nq))), "omega"),
        scale=scale,
        energy=energy_of_amplitude(system, p),
        error=frequency_error_of,
        compiled=braking,
    )


def powers(sizes: Vector) -> Vector:
    """The nearest powers of two: dividing by them and multiplying again loses nothing."""
    return np.exp2(np.round(np.log2(sizes)))


def frequency_error(point: Point) -> float:
    """How far off omega may be, relative: what rounding left in the residual, through [J; t]^-1.

    Beside a branch point this grows with the inverse of the distance, as the error does; at one nothing is known, NaN.
    """
    axis = np.zeros(len(point.y))
    axis[-1] = 1.0
    try:
        row = solve(bordered(point.jacobian, point.tangent).T, axis)
    except np.linalg.LinAlgError:
        return float("nan")
    noise: Any = point.extra.found.noise
    return float(np.abs(row[:-1]) @ noise / abs(point.y[-1]))
