"""Periodic motions of a driven chain as Fourier series: the balance of all harmonics under A cos(omega t), its phase that of the series."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

import numpy as np

from phichain.continuation import Evaluation, Problem
from phichain.continuation.problem import LateExtra
from phichain.orbits.forced.floquet import Linear, linear_of_series
from phichain.orbits.forced.forcing import Forcing
from phichain.orbits.harmonics.balance import NEEDED, Balanced, Inverse, balanced
from phichain.orbits.harmonics.basis import Basis, Kind, basis
from phichain.orbits.harmonics.elimination import Harmonics, Memory, Series, Split, eliminated
from phichain.orbits.quarter import powers
from phichain.system import Parameters, System, Vector

__all__ = ["NEEDED", "Found", "forced_problem", "kind_of"]


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


_LEAST: Final = 3
"""Harmonic up to which none is eliminated."""
_FASTER: Final = 1.2
"""Frequency, in the highest one of the hanging chain, beyond which no harmonic resonates."""
_MOST: Final = 41
"""Harmonic beyond which every one is eliminated."""


def least_outer(forcing: Forcing) -> int:
    """How many functions of the basis are never eliminated."""
    return basis(kind_of(forcing), _LEAST).size


def outer_of(system: System, forcing: Forcing, p: Parameters | None, slowest: float) -> int:
    """How many functions of the basis are not eliminated: all harmonics that could resonate with the chain, and the mean.

    Swinging far only lowers frequencies, so that those of small oscillations bound them: det (K - w^2 M) = 0 with K = u_q, M = u_a at rest.

    Args:
        system: The chain.
        forcing: What drives it.
        p: Runtime parameters.
        slowest: Lowest frequency of the forcing, rad/s.
    """
    still = np.zeros((1, system.nq))
    base = (np.zeros((1, forcing.base.size)),) if forcing.base.size else ()
    _, stiffness, _, mass = system.function(NEEDED[0])(still, still, still, *base, **system.parameters(p))
    # A cart that is free moves against the links and makes them faster; one that is told to stand leaves them as they are.
    squares = np.linalg.eigvals(np.linalg.solve(mass[0], stiffness[0]))
    fastest = float(np.sqrt(np.max(np.abs(squares))))
    highest = int(np.clip(np.ceil(_FASTER * fastest / slowest), _LEAST, _MOST))
    return basis(kind_of(forcing), highest | 1 if forcing.is_odd else highest).size


def forced_problem(
    system: System, forcing: Forcing, p: Parameters | None = None, *, omega: float, outer: int, harmonics: Harmonics | None = None,
    memory: Memory | None = None,
) -> Problem:  # fmt: skip
    """The balance of all harmonics as a continuation problem with the multipliers of every solution.

    Its points carry `Found`, and the tail of the spectrum as their error. Unknowns are the lowest coefficients and omega.

    Args:
        system: A planar chain with `inverse_and_jacobian`.
        forcing: What drives it.
        p: Runtime parameters.
        omega: Typical frequency, rad/s.
        outer: How many functions are not eliminated (`outer_of`).
        harmonics: How many are kept.
        memory: Solutions that the next ones are guessed from; none yet unless given.
    """
    n, kind, memory, wanted = system.nq, kind_of(forcing), memory or Memory(), harmonics or Harmonics()
    split = Split(
        kind, outer, lambda z, higher: np.concatenate([z[:-1].reshape(outer, n), higher]), _balance(system, forcing, p),
        lambda slopes: slopes[:, outer:].reshape(len(slopes), -1), lambda slopes: slopes[:, :outer].reshape(len(slopes), -1),
    )  # fmt: skip
    scale = np.append(np.ones(outer * n), powers(np.array([omega])))
    none = np.zeros((max(0, split.functions(wanted.least) - outer), n))

    def evaluate(z: Vector) -> Evaluation:
        if z[-1] > 0 and np.all(np.isfinite(z)):
            near = memory.near(z, scale)
            found = eliminated(split, z, none if near is None else near.guess(z), wanted)
            if found is not None:
                memory.keep(found[-1])
                return Evaluation(found[0], found[1], Found(system, forcing, found[-1], p))
        return Evaluation(np.full(outer * n, np.nan), np.full((outer * n, outer * n + 1), np.nan))

    return Problem(
        evaluate=evaluate, names=(*names_of(system, table_of(forcing, outer), outer), "omega"), scale=scale,
        error=lambda point: point.extra.series.tail,
    )  # fmt: skip


def kind_of(forcing: Forcing) -> Kind:
    """Which functions of the phase serve."""
    return "odd" if forcing.is_odd else "full"


class Found(LateExtra):
    """The linear map of deviations and its multipliers, made when they are asked for; the series is known at once.

    """

    def __init__(self, system: System, forcing: Forcing, series: Series, p: Parameters | None) -> None:
        """Keep the series, and what makes the rest."""
        table = table_of(forcing, len(series.coefficients))

        def made() -> tuple[Any, Linear]:
            linear = linear_of_series(system, forcing, table, series.coefficients, float(series.z[-1]), p)
            return linear.multipliers, linear

        super().__init__(made)
        self.__dict__["series"] = series

    @property
    def series(self) -> Series:
        """The solution."""
        series: Series = self.__dict__["series"]
        return series


def table_of(forcing: Forcing, size: int) -> Basis:
    """The basis of so many functions."""
    return basis(kind_of(forcing), size - 1 if forcing.is_odd else (size - 1) // 2)


def _balance(system: System, forcing: Forcing, p: Parameters | None) -> Callable[[Basis, Vector, float], Balanced]:
    """The balance under the forcing; where a cart stands on the mean is nobody's matter, and put at the origin."""

    def balance(table: Basis, series: Vector, rate: float) -> Balanced:
        found = balanced(forced_inverse(system, forcing, p, table.phase), table, series, rate)
        if system.has_cart and table.order[0] == 0:
            found.residual[0, 0], found.jacobian[0, 0], found.by_omega[0, 0] = series[0, 0], 0.0, 0.0
            found.jacobian[0, 0, 0, 0] = 1.0
        return found

    return balance


def names_of(system: System, table: Basis, count: int) -> tuple[str, ...]:
    """cos_H_theta_K and sin_H_theta_K, harmonic by harmonic; mean_theta_K first where there is a mean."""
    names = system.q_names or tuple(f"q_{k + 1}" for k in range(system.nq))
    paired = ("sin", "cos") if table.size % 2 else ("cos", "sin")
    kinds = [f"{paired[m % 2]}_{int(order)}" if order else "mean" for m, order in enumerate(table.order[:count])]
    return tuple(f"{kind}_{name}" for kind in kinds for name in names)
