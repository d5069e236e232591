"""A frequency response by shooting over the forcing's period, or half of it where the forcing is odd."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from phichain.continuation import Engine, Problem, follow, start_on
from phichain.continuation.core import Progress
from phichain.errors import ConvergenceError, UnsupportedError
from phichain.orbits.forced.floquet import tests_of
from phichain.orbits.forced.forcing import Forcing
from phichain.orbits.forced.made import ends_of, response_of
from phichain.orbits.forced.response import Response
from phichain.orbits.forced.shot import ForcedFlow, shooting_problem
from phichain.orbits.harmonics.basis import Basis, basis
from phichain.system import Parameters, System, Vector

_HIGHEST: Final = 31
"""Highest harmonic of the series that tell a shot motion's peaks; the motion itself is no series."""
_SMALLEST: Final = 1e-3


def followed(
    system: System, forcing: Forcing, ends: tuple[float, float], p: Parameters | None, flow: ForcedFlow | None, engine: Engine,
    progress: Progress | None,
) -> Response:  # fmt: skip
    """The response between two frequencies.

    Raises:
        UnsupportedError: The system has no forced flow.
        ConvergenceError: Newton did not reach a solution at the first frequency.
    """
    if flow is None:
        raise UnsupportedError(
            "method", "shooting", f"needs a forced flow with derivatives, and system '{system.name}' has none",
            'use method = "harmonics", or give the motion as flow=',
        )  # fmt: skip
    problem = shooting_problem(system, forcing, flow, omega=max(ends))
    direction = np.zeros(2 * system.nq + 1)
    direction[-1] = np.sign(ends[1] - ends[0])
    z = _begun(system, forcing, flow, ends, direction, engine)
    start = start_on(problem, z, direction, engine, fixed=True)
    branch = follow(problem, start, engine, [*tests_of(system, forcing.is_odd), *ends_of(ends)], "response", progress=progress)
    table = basis("odd" if forcing.is_odd else "full", _HIGHEST)

    def series(z: Vector) -> Vector:
        return _series(flow, forcing, table, z)

    return response_of(
        system, forcing, branch, "shooting", [series(z) for z in branch.points], table, [z[:-1] for z in branch.points],
        [(event.z[:-1], series(event.z)) for event in branch.events],
    )  # fmt: skip


def _series(flow: ForcedFlow, forcing: Forcing, table: Basis, z: Vector) -> Vector:
    """The coefficients (M, n) of a shot motion."""
    n, omega = (len(z) - 1) // 2, float(z[-1])
    states = flow.sampled(z[:-1], table.phase[1:] / omega, forcing.amplitude, omega)
    return np.asarray(table.project @ np.vstack([z[:n], states[:, :n]]))


def _begun(
    system: System, forcing: Forcing, flow: ForcedFlow, ends: tuple[float, float], direction: Vector, engine: Engine
) -> Vector:
    """A solution at the first frequency, reached through smaller amplitudes where Newton does not reach it at once.

    Raises:
        ConvergenceError: Not even through small steps.
    """
    z, reached, share = np.append(np.zeros(2 * system.nq), ends[0]), 0.0, 1.0
    while True:
        aim = min(1.0, reached + share)
        try:
            less: Problem = shooting_problem(system, replace(forcing, amplitude=aim * forcing.amplitude), flow, omega=max(ends))
            z = start_on(less, z, direction, engine, fixed=True).z(less)
        except ConvergenceError as failure:
            share /= 2
            if share < _SMALLEST:
                raise ConvergenceError(
                    "omega", ends[0], f"has no periodic motion that Newton reaches ({failure.problem})",
                    "start at a frequency farther from resonance, or with a smaller amplitude",
                ) from failure  # fmt: skip
            continue
        if aim == 1.0:
            return z
        reached, share = aim, 2 * share
