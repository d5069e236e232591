"""A frequency response by shooting over the forcing's period, or half of it where the forcing is odd."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from phichain.continuation import Engine, Problem, follow, start_on
from phichain.continuation.core import Progress
from phichain.errors import UnsupportedError
from phichain.orbits.forced.begun import begun, towards
from phichain.orbits.forced.floquet import tests_of
from phichain.orbits.forced.forcing import Forcing
from phichain.orbits.forced.made import Motion, ends_of, response_of
from phichain.orbits.forced.response import Response
from phichain.orbits.forced.shot import ForcedFlow, shooting_problem
from phichain.orbits.harmonics.basis import basis
from phichain.system import Parameters, System, Vector

_HIGHEST: Final = 31
"""Highest harmonic of the series that tell a shot motion's peaks; the motion itself is no series."""


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

    def problem_of(amplitude: float) -> Problem:
        return shooting_problem(system, replace(forcing, amplitude=amplitude), flow, omega=max(ends))

    problem = problem_of(forcing.amplitude)
    z = begun(problem_of, forcing.amplitude, np.append(np.zeros(2 * system.nq), ends[0]), ends, engine)
    start = start_on(problem, z, towards(z, ends), engine, fixed=True)
    branch = follow(problem, start, engine, [*tests_of(system, forcing.is_odd), *ends_of(ends)], "response", progress=progress)
    table = basis("odd" if forcing.is_odd else "full", _HIGHEST)

    def motion(z: Vector) -> Motion:
        n, omega = system.nq, float(z[-1])
        states = flow.sampled(z[:-1], table.phase[1:] / omega, forcing.amplitude, omega)
        return Motion(table, np.asarray(table.project @ np.vstack([z[:n], states[:, :n]])), omega, z[:-1])

    return response_of(system, forcing, branch, "shooting", motion)
