"""How large an error of a state is, of the motion."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from phichain.records import Held
from phichain.system import System, Vector

#: From an error of this on, of the motion, two runs have nothing to do with each other.
LOST: Final = 0.5


@dataclass(frozen=True, eq=False)
class Measure(Held):
    """The max norm of an error of q over what |q| reaches on the way, one at most, or of v over what |v| reaches, if that is larger.

    Small motions are thus measured by their own size, and angles that wind up not by their turns.

    Attributes:
        weights: One over those sizes, for each entry of x (nx,).
    """

    weights: Vector

    @classmethod
    def of(cls, system: System, x: Vector) -> Measure:
        """The measure of a motion with states x (m, nx)."""
        reach = np.max(np.abs(x), axis=0)
        angle, rate = float(np.max(reach[: system.nq])), float(np.max(reach[system.nq :]))
        angle = min(angle, 1.0) if angle else 1.0
        weights = np.repeat([1 / angle, 1 / (rate or 1.0)], [system.nq, system.nv])
        return cls(weights)

    def of_parts(self, off: Vector) -> Vector:
        """Sizes (m,) of errors whose largest entries of q and of v are given (m, 2)."""
        sizes: Vector = np.max(off * self.weights[[0, -1]], axis=1)
        return sizes

    def __call__(self, off: Vector) -> Vector:
        """Sizes (m,) of errors (m, nx), or one of (nx,)."""
        # Row by row over the entries: along rows of a few numbers NumPy takes ten times as long.
        weighed = np.multiply(np.transpose(off), self.weights.reshape(-1, *(1,) * (off.ndim - 1)), order="C")
        sizes: Vector = np.max(np.abs(weighed), axis=0)
        return sizes
