"""An observer along a trajectory: the deviation from it, estimated from positions alone, by tables over time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from phichain.errors import ArrayError
from phichain.laws.learning import Learning
from phichain.records import Held, held

Vector = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class ObserverAlong(Held):
    """z = z_expected + L w(y - q_r - C z_expected), with L and all below straight lines between the knots of the trajectory.

    z = (z_q, z_v) is the deviation from x_r, y what is measured of the positions, C z = z_q. For the next call

        z_v' = z_v + F z + G (u - u_r),    z_q' = z_q + T (z_v + z_v') / 2

    with F and G what rates gain in one sample T, exactly to first order: the places follow by the trapezoidal rule. Where parameters are
    known to errors alone it estimates these too; they stand behind z in its memory.

    Attributes:
        corrections: L (knots, nx, nq).
        flows: F (knots, nq, nx).
        drives: G (knots, nq, nu).
        learning: What is found out of parameters, and the observer at the target; None where nothing is.

    Raises:
        ArrayError: Shapes that do not fit one another, or numbers that are not finite.
    """

    corrections: Vector
    flows: Vector
    drives: Vector
    learning: Learning | None = None

    def __post_init__(self) -> None:
        for name in ("corrections", "flows", "drives"):
            object.__setattr__(self, name, held(getattr(self, name)))
        knots, nq, nx = self.flows.shape if self.flows.ndim == 3 else (0, 0, 0)
        wanted = {"corrections": (knots, nx, nq), "drives": (knots, nq, self.drives.shape[-1])}
        for name, shape in wanted.items():
            table = getattr(self, name)
            if not knots or nx != 2 * nq or table.shape != shape or not np.all(np.isfinite(table)) or not np.all(np.isfinite(self.flows)):
                raise ArrayError(f"observer.{name}", table, f"must hold finite numbers of shape {shape}", "give L, F and G at the same knots")
        if self.learning and (self.learning.pushes.shape[:2] != (knots, nq) or self.learning.bends.shape[2] != nx + self.drives.shape[2]):
            raise ArrayError("observer.learning", self.learning.bends.shape, "is of another chain or of other knots", "make it along the same motion")

    @property
    def remembered(self) -> int:
        """Numbers from one call to the next: z_expected; where parameters are estimated theta, and what tells a sensor that is stuck."""
        return self.estimated + (self.learning.kept if self.learning else 0)

    @property
    def estimated(self) -> int:
        """Numbers of (z, theta)."""
        return int(self.corrections.shape[1]) + (self.learning.count if self.learning else 0)

    def corrected(self, weights: tuple[int, int, float], expected: Vector, off: ArrayLike) -> Vector:
        """(z, theta) where `expected` is what was expected of them and `off` w(y - q_r - C z_expected) (nq,); weights (j, k, f): a share f of the way from knot j to k."""
        nx = self.corrections.shape[1]
        if not self.learning:
            return np.asarray(expected + _between(self.corrections, weights) @ np.asarray(off))
        if self._is_last(weights):
            return np.concatenate([self.learning.corrected(expected[:nx], off), expected[nx:]])
        found = expected + np.vstack([_between(self.corrections, weights), _between(self.learning.learned, weights)]) @ np.asarray(off)
        return np.concatenate([found[:nx], np.clip(found[nx:], -self.learning.bounds, self.learning.bounds)])

    def following(self, weights: tuple[int, int, float], found: Vector, pushed: Vector, sample: float) -> Vector:
        """What the next call expects, (z_expected, theta), after inputs that were u - u_r (nu,) off."""
        nx = self.corrections.shape[1]
        nq, z, theta = nx // 2, found[:nx], found[nx:]
        rates = z[nq:] + _between(self.flows, weights) @ z + _between(self.drives, weights) @ pushed
        if self.learning:
            is_last = self._is_last(weights)
            rates = rates + (self.learning.gained(theta, z, pushed) if is_last else _between(self.learning.pushes, weights) @ theta)
        return np.concatenate([z[:nq] + sample * (z[nq:] + rates) / 2, rates, theta])

    def _is_last(self, weights: tuple[int, int, float]) -> bool:
        return weights[0] == len(self.corrections) - 1


def _between(table: Vector, weights: tuple[int, int, float]) -> Vector:
    j, k, f = weights
    return np.asarray(table[j] + f * (table[k] - table[j]))
