"""Brake orbits by many harmonics, the equations of all but the first eliminated: unknowns (q_0, omega), as in a quarter period's shooting.

theta(tau) = sum X_h cos h tau over odd h, X_1 = q_0 - X_3 - X_5 - ..; the balances R_3 = R_5 = .. = 0 make W = (X_3, X_5, ..) a function of
(q_0, omega). With the exact Jacobian of all balances, G = dR/dW and E = dR/d(q_0, omega) at fixed W,

    F = R_1 - G_1 G_W^-1 R_W,   dF/d(q_0, omega) = E_1 - G_1 G_W^-1 E_W,   dW/d(q_0, omega) = -G_W^-1 E_W,

so that a continuation sees as many unknowns whatever the number of harmonics, which is raised until the tail of the spectrum is as small
as wanted. Where some higher harmonic resonates G_W is singular, and nothing can be condensed: such places are left to shooting.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from phichain.continuation import Evaluation, Extra, Problem
from phichain.errors import ArrayError
from phichain.orbits.harmonics.balance import Inverse, balanced, inverse_of
from phichain.orbits.harmonics.basis import basis, resized, tail
from phichain.orbits.harmonics.sketch import sketched
from phichain.orbits.quarter import powers
from phichain.orbits.single_harmonic import energy_of_amplitude
from phichain.records import Held
from phichain.system import Parameters, System, Vector
from phichain.system.arrays import positive, whole

TAIL: Final = 1e-12
"""Size of the two highest harmonics, in the largest, at which a series is whole."""
MOST: Final = 127
"""Highest harmonic that is tried."""
LADDER: Final = (7, 11, 15, 23, 31, 47, 63, 95, 127, 191, 255, 383, 511, 767, 1023)
"""Highest harmonics, one after the other."""
_LARGEST: Final = 4095
"""A harmonic beyond which nobody should wait for a balance."""
_SETTLED: Final = 1e-8
"""Correction of the higher harmonics, in the largest one, whose square is no more than rounding."""
_ITERATIONS: Final = 12
_SPARE: Final = 1e-3
"""Tails this much smaller than wanted are cut at the next lower step of the ladder."""
_KEPT: Final = 4
"""Solutions that guesses are taken from."""


@dataclass(frozen=True, eq=False)
class Series(Held):
    """A brake orbit as a sum of odd cosines.

    Attributes:
        z: (q_0, omega) (n + 1,).
        coefficients: X_1, X_3, .. (M, n).
        by_z: Derivatives of X_3, X_5, .. by (q_0, omega), ((M - 1) n, n + 1).
        tail: The two highest harmonics, in the largest.
    """

    z: Vector
    coefficients: Vector
    by_z: Vector
    tail: float

    @property
    def highest(self) -> int:
        """The highest harmonic."""
        return 2 * len(self.coefficients) - 1

    @property
    def overtones(self) -> float:
        """The largest harmonic above the first, in the first."""
        sizes = np.max(np.abs(self.coefficients), axis=1)
        return float(np.max(sizes[1:]) / sizes[0]) if sizes[0] > 0 else float("inf")

    def guess(self, z: Vector) -> Vector:
        """The higher harmonics (M - 1, n) at another z, to the first order."""
        higher = self.coefficients[1:]
        return higher + (self.by_z @ (z - self.z)).reshape(higher.shape)


@dataclass(frozen=True)
class Harmonics:
    """How many harmonics are kept.

    Attributes:
        tail: Size of the two highest, in the largest, at which there are enough.
        most: The highest that is tried.
        least: The highest that is kept at least.

    Raises:
        ArrayError: The harmonics do not rise, or the tail is no share.
    """

    tail: float = TAIL
    most: int = MOST
    least: int = LADDER[0]

    def __post_init__(self) -> None:
        object.__setattr__(self, "tail", positive("harmonics.tail", self.tail, "use 1e-12"))
        for name in ("most", "least"):
            value = whole(f"harmonics.{name}", getattr(self, name), 3, _LARGEST, "give an odd harmonic such as 39", ArrayError)
            object.__setattr__(self, name, value | 1)
        if not self.least <= self.most or not self.tail < 1:
            raise ArrayError(
                "harmonics", (self.tail, self.least, self.most), "must be a tail below 1, and harmonics that rise", "leave them out"
            )

    def above(self, highest: int, found: float) -> int:
        """The next number to try: as many as the decay so far makes of the wanted tail, and one step of the ladder at least."""
        wanted = highest * np.log(self.tail) / np.log(found) if found < 1 else 2.0 * highest
        step = next((rung for rung in LADDER if rung > highest and rung >= wanted), 2 * highest + 1)
        return int(min(self.most, max(step, self.least)))

    def below(self, highest: int) -> int:
        """The next lower step."""
        return max(self.least, next((rung for rung in reversed(LADDER) if rung < highest), highest))


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


@dataclass
class _Memory:
    """The last solutions, from which Newton's iteration starts: no result but its rounding depends on them."""

    last: list[Series] = field(default_factory=list)

    def keep(self, found: Series) -> None:
        self.last = [*self.last[1 - _KEPT :], found]

    def near(self, z: Vector, sizes: Vector) -> Series | None:
        return min(self.last, key=lambda one: float(np.max(np.abs((one.z - z) / sizes))), default=None)


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
    inverse, memory, wanted = inverse_of(system, p), _Memory(), harmonics or Harmonics()
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
                found = _condensed(inverse, z, guess, wanted)
                if found is not None:
                    memory.keep(found.extra.found)
                    return found
        return Evaluation(np.full(n, np.nan), np.full((n, n + 1), np.nan))

    return Problem(
        evaluate=evaluate,
        names=(*(system.q_names or tuple(f"q_{k + 1}" for k in range(n))), "omega"),
        scale=scale,
        energy=energy_of_amplitude(system, p),
        error=lambda point: point.extra.found.tail,
    )


def _condensed(inverse: Inverse, z: Vector, guess: Vector, wanted: Harmonics) -> Evaluation | None:
    """F, its Jacobian and the Series at z, by Newton's iteration for the higher harmonics; None where it fails."""
    n, higher, before = len(z) - 1, guess, np.inf
    for _ in range(_ITERATIONS):
        coefficients = np.concatenate([[z[:-1] - higher.sum(axis=0)], higher])
        size = len(coefficients)
        found = balanced(inverse, basis("odd cosines", 2 * size - 1), coefficients, float(z[-1]))
        by_first = found.jacobian[:, :, :1]
        by_higher = (found.jacobian[:, :, 1:] - by_first).reshape(size * n, -1)
        own = np.column_stack([found.residual.ravel(), by_first.reshape(size * n, n), found.by_omega.ravel()])
        try:
            answer = np.linalg.solve(by_higher[n:], own[n:])
        except np.linalg.LinAlgError:
            return None
        step, largest = float(np.max(np.abs(answer[:, 0]))), float(np.max(np.abs(coefficients)))
        if not step < 2 * before:
            return None
        before = step
        higher = higher - answer[:, 0].reshape(higher.shape)
        if step > _SETTLED * largest:
            continue
        coefficients = np.concatenate([[z[:-1] - higher.sum(axis=0)], higher])
        left = tail(coefficients, basis("odd cosines", 2 * size - 1).order)
        highest = 2 * size - 1
        if left > wanted.tail and highest < wanted.most:
            higher, before = resized(higher, (wanted.above(highest, left) - 1) // 2), np.inf
            continue
        reduced = own[:n] - by_higher[:n] @ answer
        by_z: Vector = np.negative(answer[:, 1:])
        series = _trimmed(Series(z.copy(), coefficients, by_z, left), wanted)
        return Evaluation(reduced[:, 0], reduced[:, 1:], Extra(found=series))
    return None


def _trimmed(series: Series, wanted: Harmonics) -> Series:
    """The same with fewer harmonics, where those left out are far below what is wanted."""
    size, n = series.coefficients.shape
    fewer = (wanted.below(series.highest) + 1) // 2
    if fewer >= size:
        return series
    left = float(np.max(np.abs(series.coefficients[fewer - 2 :]))) / float(np.max(np.abs(series.coefficients)))
    if left > _SPARE * wanted.tail:
        return series
    return Series(series.z, series.coefficients[:fewer], series.by_z[: (fewer - 1) * n], left)
