"""Higher harmonics eliminated from the balance, as many as the tail of the spectrum asks for.

With W the coefficients of the higher harmonics and z all other unknowns, R_W = 0 makes W a function of z. With the exact Jacobian of all
balances, G = dR/dW and E = dR/dz at fixed W, Newton's iteration for W comes with

    F = R_z - G_z G_W^-1 R_W,   dF/dz = E_z - G_z G_W^-1 E_W,   dW/dz = -G_W^-1 E_W,

so that a continuation sees as many unknowns whatever the number of harmonics. Where a higher harmonic resonates G_W is singular, and
nothing can be eliminated: such places are left to shooting.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from phichain.errors import ArrayError
from phichain.orbits.harmonics.balance import Balanced
from phichain.orbits.harmonics.basis import Basis, Kind, basis, resized, tail
from phichain.records import Held
from phichain.system import Vector
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
    """A solution of the balance.

    Attributes:
        z: The unknowns that are left (k,).
        coefficients: All of them (M, n).
        outer: How many functions of the basis, the first ones, are not eliminated.
        by_z: Derivatives of the others' coefficients by z ((M - outer) n, k).
        tail: The two highest harmonics, in the largest.
    """

    z: Vector
    coefficients: Vector
    outer: int
    by_z: Vector
    tail: float

    @property
    def overtones(self) -> float:
        """The largest coefficient of those eliminated, in the largest of the others."""
        sizes = np.max(np.abs(self.coefficients), axis=1)
        first = np.max(sizes[: self.outer])
        return float(np.max(sizes[self.outer :]) / first) if first > 0 else float("inf")

    def guess(self, z: Vector) -> Vector:
        """The higher harmonics (M - outer, n) at another z, to the first order."""
        higher = self.coefficients[self.outer :]
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


@dataclass
class Memory:
    """The last solutions, from which Newton's iteration starts: no result but its rounding depends on them."""

    last: list[Series] = field(default_factory=list)

    def keep(self, found: Series) -> None:
        """Remember a solution, and forget an old one."""
        self.last = [*self.last[1 - _KEPT :], found]

    def near(self, z: Vector, sizes: Vector) -> Series | None:
        """The solution nearest to z; None where there is none."""
        if not self.last:
            return None
        apart = np.abs((np.array([one.z for one in self.last]) - z) / sizes).max(axis=1)
        return self.last[int(apart.argmin())]


@dataclass(frozen=True)
class Split:
    """How unknowns and coefficients hang together.

    Attributes:
        kind: Functions of the phase.
        outer: How many of them, the first ones, are not eliminated.
        whole: z, W (M - outer, n) -> the coefficients X (M, n).
        balance: basis, X, omega -> the balance of all harmonics.
        by_higher: dR/dX (M n, M, n) -> dR/dW (M n, (M - outer) n).
        by_outer: The same -> dR/d(z without omega).
    """

    kind: Kind
    outer: int
    whole: Callable[[Vector, Vector], Vector]
    balance: Callable[[Basis, Vector, float], Balanced]
    by_higher: Callable[[Vector], Vector]
    by_outer: Callable[[Vector], Vector]

    def functions(self, highest: int) -> int:
        """M, the number of functions up to a harmonic."""
        return basis(self.kind, highest).size

    def highest(self, size: int) -> int:
        """The highest harmonic of so many functions."""
        return {"odd cosines": 2 * size - 1, "odd": size - 1, "full": (size - 1) // 2}[self.kind]


def eliminated(split: Split, z: Vector, guess: Vector, wanted: Harmonics) -> tuple[Vector, Vector, Series] | None:
    """F, dF/dz and the Series at z, by Newton's iteration for the higher harmonics; None where it fails.

    Args:
        split: What is eliminated.
        z: The unknowns, omega last.
        guess: W (M - outer, n).
        wanted: How many harmonics are kept.
    """
    higher, before = guess, np.inf
    for _ in range(_ITERATIONS):
        coefficients = split.whole(z, higher)
        size, n = coefficients.shape
        table, kept = basis(split.kind, split.highest(size)), split.outer * n
        found = split.balance(table, coefficients, float(z[-1]))
        slopes = found.jacobian.reshape(size * n, size, n)
        by_higher = split.by_higher(slopes)
        own = np.empty((size * n, len(z) + 1))
        own[:, 0], own[:, 1:-1], own[:, -1] = found.residual.ravel(), split.by_outer(slopes), found.by_omega.ravel()
        try:
            answer = np.linalg.solve(by_higher[kept:], own[kept:])
        except np.linalg.LinAlgError:
            return None
        step, largest = float(np.abs(answer[:, 0]).max(initial=0.0)), float(np.abs(coefficients).max())
        is_settled = step <= _SETTLED * max(largest, _SETTLED)
        if not (is_settled or step < 2 * before):
            return None
        before = step
        higher = higher - answer[:, 0].reshape(higher.shape)
        if not is_settled:
            continue
        coefficients = split.whole(z, higher)
        left = tail(coefficients, table)
        if left > wanted.tail and table.highest < wanted.most:
            more = split.functions(wanted.above(table.highest, left)) - split.outer
            higher, before = resized(higher, more), np.inf
            continue
        reduced = own[:kept] - by_higher[:kept] @ answer
        by_z: Vector = np.negative(answer[:, 1:])
        series = _trimmed(
            split, Series.made(z=z.copy(), coefficients=coefficients, outer=split.outer, by_z=by_z, tail=left), table, wanted
        )
        return reduced[:, 0], reduced[:, 1:], series
    return None


def _trimmed(split: Split, series: Series, table: Basis, wanted: Harmonics) -> Series:
    """The same with fewer harmonics, where those left out are far below what is wanted."""
    lower = basis(split.kind, wanted.below(table.highest))
    fewer = lower.size
    if fewer >= table.size or fewer < split.outer:
        return series
    largest = float(np.abs(series.coefficients).max())
    left = float(np.abs(series.coefficients[lower.last :]).max())
    if left > _SPARE * wanted.tail * largest:
        return series
    n = series.coefficients.shape[1]
    return Series(series.z, series.coefficients[:fewer], split.outer, series.by_z[: (fewer - split.outer) * n], left / largest if largest else 0.0)
