"""Periodic motions of a driven chain as Fourier series: the balance of all harmonics under A cos(omega t), its phase that of the series.

Unknowns are the coefficients X and omega. Nothing is condensed: a fold of the response is a fold in all of them, and a superharmonic
resonance may fold the higher harmonics alone.
"""

from __future__ import annotations

from typing import Any, Final

import numpy as np

from phichain.continuation import Evaluation, Problem
from phichain.continuation.problem import LateExtra
from phichain.orbits.forced.floquet import Linear, linear_of_series
from phichain.orbits.forced.forcing import Forcing
from phichain.orbits.harmonics.balance import NEEDED, Balanced, Inverse, balanced
from phichain.orbits.harmonics.basis import Basis
from phichain.orbits.quarter import powers
from phichain.system import Parameters, System, Vector

__all__ = ["NEEDED", "coefficients_of", "forced_inverse", "forced_problem", "names_of"]
_SIZE: Final = 1.0


def forced_inverse(system: System, forcing: Forcing, p: Parameters | None, phase: Vector) -> Inverse:
    """The equations of motion at some phases, the forcing on their left: u - Q A cos tau, the cart's x'' - A cos tau where that is given."""
    function, parameters = system.function(NEEDED[0]), system.parameters(p)
    drive = forcing.amplitude * np.cos(phase)[:, None]
    base = (drive * forcing.base,) if forcing.base.size else ()

    def inverse(q: Vector, v: Vector, a: Vector) -> tuple[Vector, Vector, Vector, Vector]:
        u, by_q, by_v, by_a = function(q, v, a, *base, **parameters)
        u = u - drive * forcing.force
        if forcing.told:
            u[:, 0] = a[:, 0] - drive[:, 0]
            by_q[:, 0], by_v[:, 0], by_a[:, 0] = 0.0, 0.0, np.eye(q.shape[1])[0]
        return u, by_q, by_v, by_a

    return inverse


def forced_problem(system: System, forcing: Forcing, basis: Basis, p: Parameters | None = None, *, omega: float) -> Problem:
    """R(X, omega) = 0 as a continuation problem with the multipliers of every solution.

    Args:
        system: A planar chain with `inverse_and_jacobian`.
        forcing: What drives it.
        basis: "odd" where the forcing is, else "full".
        p: Runtime parameters.
        omega: Typical frequency, rad/s.
    """
    size, n = basis.size, system.nq
    inverse = forced_inverse(system, forcing, p, basis.phase)
    gauged = basis.order[0] == 0 and system.has_cart

    def evaluate(z: Vector) -> Evaluation:
        unknowns = size * n
        if not (z[-1] > 0 and np.all(np.isfinite(z))):
            return Evaluation(np.full(unknowns, np.nan), np.full((unknowns, unknowns + 1), np.nan))
        series, rate = z[:-1].reshape(size, n), float(z[-1])
        found: Balanced = balanced(inverse, basis, series, rate)
        residual = found.residual.ravel()
        jacobian = np.column_stack([found.jacobian.reshape(unknowns, unknowns), found.by_omega.ravel()])
        if gauged:
            # Where a cart stands on the mean is nobody's matter: at the origin.
            residual[0], jacobian[0] = series[0, 0], 0.0
            jacobian[0, 0] = 1.0

        def stability() -> tuple[Any, Linear]:
            linear = linear_of_series(system, forcing, basis, series, rate, p)
            return linear.multipliers, linear

        return Evaluation(residual, jacobian, LateExtra(stability))

    return Problem(
        evaluate=evaluate, names=(*names_of(system, basis), "omega"),
        scale=np.append(np.ones(size * n), powers(np.array([omega]))),
    )  # fmt: skip


def names_of(system: System, basis: Basis) -> tuple[str, ...]:
    """cos_H_theta_K and sin_H_theta_K, harmonic by harmonic; mean_theta_K first where there is a mean."""
    names = system.q_names or tuple(f"q_{k + 1}" for k in range(system.nq))
    paired = ("sin", "cos") if len(basis.order) % 2 else ("cos", "sin")
    kinds = [f"{paired[m % 2]}_{int(order)}" if order else "mean" for m, order in enumerate(basis.order)]
    return tuple(f"{kind}_{name}" for kind in kinds for name in names)


def coefficients_of(z: Vector, n: int) -> Vector:
    """X (M, n) of the unknowns."""
    return z[:-1].reshape(-1, n)
