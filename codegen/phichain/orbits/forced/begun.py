"""The first driven motion of a response, reached through smaller amplitudes where Newton does not reach it at once."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

import numpy as np

from phichain.continuation import Engine, Problem, start_on
from phichain.errors import ConvergenceError
from phichain.system import Vector

_SMALLEST: Final = 1e-3
"""Share of the amplitude below which steps towards it are given up."""


def towards(z: Vector, ends: tuple[float, float]) -> Vector:
    """Along omega, the last unknown, from the first frequency to the second."""
    direction = np.zeros(len(z))
    direction[-1] = np.sign(ends[1] - ends[0])
    return direction


def begun(problem_of: Callable[[float], Problem], amplitude: float, z: Vector, ends: tuple[float, float], engine: Engine) -> Vector:
    """The unknowns of a solution at the first frequency.

    Args:
        problem_of: The problem under a forcing of some amplitude.
        amplitude: That of the response.
        z: Rest, at the first frequency.
        ends: First and last frequency.
        engine: Corrector and options.

    Raises:
        ConvergenceError: Newton does not reach one, not even through small steps.
    """
    reached, share = 0.0, 1.0
    while True:
        aim = min(1.0, reached + share)
        problem = problem_of(aim * amplitude)
        try:
            z = start_on(problem, z, towards(z, ends), engine, fixed=True).z(problem)
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
