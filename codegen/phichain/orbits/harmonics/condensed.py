"""Brake orbits by many harmonics, condensed: unknowns (q_0, omega), as in a quarter period's shooting.

theta(tau) = sum X_h cos h tau over odd h, X_1 = q_0 - X_3 - X_5 - ..; the balances of the harmonics above the first are solved for them
(`elimination`), and that of the first one is what is left.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from phichain.continuation import Evaluation, Extra, Problem
from phichain.errors import ArrayError
from phichain.orbits.harmonics.balance import balanced, inverse_of
from phichain.orbits.harmonics.elimination import Harmonics, Memory, Split, eliminated
from phichain.orbits.harmonics.sketch import sketched
from phichain.orbits.quarter import powers
from phichain.orbits.single_harmonic import energy_of_amplitude
from phichain.system import Parameters, System, Vector
from phichain.system.arrays import whole

__all__ = ["Harmonics", "condensed_problem", "kept_harmonics"]
_LARGEST = 4095
"""A harmonic beyond which nobody should wait for a balance."""


def kept_harmonics(given: Harmonics | int, method: str) -> Harmonics:
    """How many harmonics are meant: what was given, or one highest harmonic for all points.

    Raises:
        ArrayError: It is neither, the harmonic is even, or the method has one harmonic or all of them.
    """
    if method != "harmonics":
        raise ArrayError("harmonics", given, f'belong to method = "harmonics", and this is "{method}"', "leave them out")
    if isinstance(given, Harmonics):
        return given
    highest = whole("harmonics", given, 3, _LARGEST, "give the highest harmonic, an odd number such as 39", ArrayError)
    if highest % 2 == 0:
        raise ArrayError("harmonics", given, "is even, and brake orbits have odd harmonics alone", f"use {highest + 1}")
    return Harmonics(most=highest, least=highest)


def condensed_problem(
    system: System, p: Parameters | None = None, *, omega: float, shape: Vector, harmonics: Harmonics | None = None
) -> Problem:
    """The balance of all harmonics as a continuation problem with unknowns (q_0, omega).

    Its points carry their `Series` in extra.found, and the tail of the spectrum as their error; a balance computes no multipliers.

    Args:
        system: A planar chain without losses, with `inverse_and_jacobian` and `forward_dynamics`.
        p: Runtime parameters.
        omega: Frequency of the linear mode, rad/s: its size.
        shape: Shape of the mode (n,); a cart counts in units of its share.
        harmonics: How many are kept.

    Raises:
        AbsentFunctionError: A function is missing.
    """
    inverse, memory, wanted = inverse_of(system, p), Memory(), harmonics or Harmonics()
    split = Split(
        "odd cosines", 1, _from_start, lambda table, series, rate: balanced(inverse, table, series, rate),
        lambda slopes: (slopes[:, 1:] - slopes[:, :1]).reshape(len(slopes), -1), lambda slopes: slopes[:, 0],
    )  # fmt: skip
    carts, n = system.cart_size, system.nq
    sizes = np.abs(np.concatenate([shape[:carts], np.ones(n - carts), [omega]]))
    scale = powers(np.where(sizes > 0, sizes, 1.0))

    def starts(z: Vector) -> Iterator[Vector]:
        """Guesses of the higher harmonics, the nearest first; made when they are needed."""
        near = memory.near(z, scale)
        yield np.zeros(((wanted.least - 1) // 2, n)) if near is None else near.guess(z)
        drawn = sketched(system, p, z, wanted.least)
        if drawn is not None:
            yield drawn

    def evaluate(z: Vector) -> Evaluation:
        if z[-1] > 0 and np.all(np.isfinite(z)):
            for guess in starts(z):
                found = eliminated(split, z, guess, wanted)
                if found is not None:
                    memory.keep(found[-1])
                    return Evaluation(found[0], found[1], Extra(found=found[-1]))
        return Evaluation(np.full(n, np.nan), np.full((n, n + 1), np.nan))

    return Problem(
        evaluate=evaluate,
        names=(*(system.q_names or tuple(f"q_{k + 1}" for k in range(n))), "omega"),
        scale=scale,
        energy=energy_of_amplitude(system, p),
        error=lambda point: point.extra.found.tail,
    )


def _from_start(z: Vector, higher: Vector) -> Vector:
    """All coefficients: the first ones are what is left of q_0."""
    return np.concatenate([[z[:-1] - higher.sum(axis=0)], higher])
