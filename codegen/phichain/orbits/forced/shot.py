"""Periodic motions of a driven chain by shooting: x(T/2) = -x(0) where the forcing is odd, else x(T) = x(0), T = 2 pi / omega.

Unknowns are the state at phase zero and omega; one propagation with its derivatives gives the residual, its Jacobian and the multipliers.
"""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np

from phichain.continuation import Evaluation, Point, Problem
from phichain.continuation.problem import LateExtra
from phichain.errors import UnsupportedError
from phichain.orbits.forced.floquet import Linear, deviating
from phichain.orbits.forced.forcing import Forcing
from phichain.orbits.quarter import powers
from phichain.system import System, Vector


class ForcedFlow(Protocol):
    """The motion of a driven chain from phase zero, with its derivatives."""

    def __call__(self, x: Vector, span: float, amplitude: float, omega: float) -> tuple[Vector, Vector, Vector] | None:
        """x(span), its derivatives by x(0) (2 n, 2 n), and by omega (2 n,) while omega span stays; None where it cannot be followed."""
        ...

    def sampled(self, x: Vector, times: Vector, amplitude: float, omega: float) -> Vector:
        """The states (K, 2 n) at rising times."""
        ...


def shooting_problem(
    system: System, forcing: Forcing, flow: ForcedFlow, *, omega: float, periods: int | None = None
) -> Problem:
    """Closing of the motion as a continuation problem with unknowns (q_0, v_0, omega) and the multipliers of every solution.

    Args:
        system: A planar chain.
        forcing: What drives it.
        flow: Its motion.
        omega: Typical frequency, rad/s.
        periods: After how many periods of the forcing the motion comes back; one, and its mirror image after half of it where the
            forcing is odd, unless given.

    Raises:
        UnsupportedError: A cart may close its period anywhere.
    """
    if system.has_cart and (periods is not None or not forcing.is_odd):
        raise UnsupportedError(
            "base", system.base, "lets the chain close its period anywhere on the rail, and there is no symmetry to tell where",
            'use method = "harmonics", which puts the mean place at the origin, or base = "fixed"',
        )  # fmt: skip
    size = 2 * system.nq
    is_half = forcing.is_odd and periods is None
    share, sign = (0.5, -1.0) if is_half else (float(periods or 1), 1.0)
    kept = deviating(system, forcing)

    def evaluate(z: Vector) -> Evaluation:
        rate = float(z[-1])
        found = flow(z[:-1], share * 2 * np.pi / rate, forcing.amplitude, rate) if rate > 0 and np.all(np.isfinite(z)) else None
        if found is None:
            return Evaluation(np.full(size, np.nan), np.full((size, size + 1), np.nan))
        end, by_start, by_omega = found

        def stability() -> tuple[Any, Linear]:
            linear = Linear(sign * by_start[np.ix_(kept, kept)], is_half)
            return linear.multipliers, linear

        jacobian = np.column_stack([by_start - sign * np.eye(size), by_omega])
        return Evaluation(end - sign * z[:-1], jacobian, LateExtra(stability))

    n, typical = system.nq, float(powers(np.array([omega]))[0])
    names = (*(system.q_names or tuple(f"q_{k + 1}" for k in range(n))), *(system.v_names or tuple(f"v_{k + 1}" for k in range(n))))
    return Problem(
        evaluate=evaluate, names=(*names, "omega"), scale=np.concatenate([np.ones(n), np.full(n + 1, typical)]),
        error=_correction,
    )  # fmt: skip


def _correction(point: Point) -> float:
    """What rounding may be wrong with a point: its relative residual through [J; t]^-1, in its largest unknown."""
    bordered = np.vstack([point.jacobian, point.tangent])
    left = point.residual * (np.abs(point.jacobian) @ np.abs(point.y))
    return float(np.max(np.abs(np.linalg.inv(bordered)[:, :-1]) @ left) / np.max(np.abs(point.y)))
