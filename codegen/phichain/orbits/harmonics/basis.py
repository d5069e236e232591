"""Which functions of the phase tau = omega t an orbit is a sum of, tabulated where the equations of motion are evaluated.

    odd cosines   cos h tau, h = 1, 3, .. H                theta(-t) = theta(t), theta(t + T/2) = -theta(t): brake orbits
    odd           cos h tau, sin h tau, h = 1, 3, .. H     theta(t + T/2) = -theta(t)
    full          1, cos h tau, sin h tau, h = 1, 2, .. H

Where the orbit has a symmetry its residual has it too, so that a quarter or a half of the period tells all. There are twice as many
samples as functions: what a product folds back onto the functions kept comes from beyond the harmonic 3 H.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Final, Literal

import numpy as np

from phichain.records import Held
from phichain.system import Vector

Kind = Literal["odd cosines", "odd", "full"]
KINDS: Final = ("odd cosines", "odd", "full")
_KEPT: Final = 64
"""Tables that are kept."""


@dataclass(frozen=True, eq=False)
class Basis(Held):
    """M functions of the phase at K places.

    Attributes:
        kind: One of KINDS.
        highest: H, the highest harmonic.
        order: Harmonic of every function (M,).
        phase: tau of the samples (K,), over a quarter, a half or the whole of a period.
        value: The functions there (K, M).
        slope: Their first derivatives by tau (K, M).
        bend: Their second ones (K, M).
        project: Samples (K,) -> coefficients (M,).
        last: Where the functions of the two highest harmonics begin.
    """

    kind: Kind
    highest: int
    order: Vector
    phase: Vector
    value: Vector
    slope: Vector
    bend: Vector
    project: Vector
    last: int

    @property
    def size(self) -> int:
        """M."""
        return len(self.order)

    def at(self, phase: Vector) -> tuple[Vector, Vector, Vector]:
        """The functions and their first two derivatives by tau at other phases, (len(phase), M) each."""
        return _tables(self.kind, self.order, np.asarray(phase, float))


@lru_cache(maxsize=_KEPT)
def basis(kind: Kind, highest: int) -> Basis:
    """The functions up to a harmonic; an odd one where only such occur."""
    step = 1 if kind == "full" else 2
    harmonics = np.arange(1.0, highest + 1, step)
    order: Vector = harmonics if kind == "odd cosines" else np.repeat(harmonics, 2)
    if kind == "full":
        order = np.concatenate([[0.0], order])
    phase = _phases(kind, len(order), highest)
    value, slope, bend = _tables(kind, order, phase)
    project = 2 / len(phase) * value.T
    project[order == 0] /= 2
    last = int(np.searchsorted(order, np.unique(order)[-2])) if len(order) > 1 else 0
    return Basis(kind, highest, order, phase, value, slope, bend, project, last)


def _phases(kind: Kind, size: int, highest: int) -> Vector:
    """Equally spaced places, those of a quarter period half a space away from its ends."""
    if kind == "odd cosines":
        count = 2 * size
        return np.pi / 2 * (np.arange(count) + 0.5) / count
    span, count = (np.pi, 2 * (highest + 1)) if kind == "odd" else (2 * np.pi, 4 * (highest + 1))
    return span * np.arange(count) / count


def _tables(kind: Kind, order: Vector, phase: Vector) -> tuple[Vector, Vector, Vector]:
    angle = np.outer(phase, order)
    value, slope = np.cos(angle), -order * np.sin(angle)
    if kind != "odd cosines":
        # Pairs (cos, sin), after the constant where there is one.
        sines = slice(len(order) % 2 + 1, None, 2)
        value[:, sines], slope[:, sines] = np.sin(angle[:, sines]), order[sines] * np.cos(angle[:, sines])
    return value, slope, -(order**2) * value


def resized(coefficients: Vector, size: int) -> Vector:
    """Coefficients (M, n) of a basis of the same kind with other harmonics: zeros added, or the highest ones left out."""
    kept = coefficients[:size]
    return np.concatenate([kept, np.zeros((size - len(kept), coefficients.shape[1]))]) if len(kept) < size else kept


def tail(coefficients: Vector, table: Basis) -> float:
    """The two highest harmonics, in the largest coefficient."""
    sizes = np.abs(coefficients)
    largest = sizes.max()
    return float(sizes[table.last :].max() / largest) if largest > 0 else 0.0
