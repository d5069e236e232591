"""An observer along a trajectory: the deviation from it, estimated from positions alone, by tables over time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from phichain.errors import ArrayError
from phichain.records import Held, held

Vector = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class ObserverAlong(Held):
    """z = z_expected + L w(y - q_r - C z_expected), with L and all below straight lines between the knots of the trajectory.

    z = (z_q, z_v) is the deviation from x_r, y what is measured of the positions, C z = z_q. For the next call

        z_v' = z_v + F z + G (u - u_r),    z_q' = z_q + T (z_v + z_v') / 2

    with F and G what rates gain in one sample T, exactly to first order: the places follow by the trapezoidal rule.

    Attributes:
        corrections: L (knots, nx, nq).
        flows: F (knots, nq, nx).
        drives: G (knots, nq, nu).

    Raises:
        ArrayError: Shapes that do not fit one another, or numbers that are not finite.
    """

    corrections: Vector
    flows: Vector
    drives: Vector

    def __post_init__(self) -> None:
        for name in ("corrections", "flows", "drives"):
            object.__setattr__(self, name, held(getattr(self, name)))
        knots, nq, nx = self.flows.shape if self.flows.ndim == 3 else (0, 0, 0)
        wanted = {"corrections": (knots, nx, nq), "drives": (knots, nq, self.drives.shape[-1])}
        for name, shape in wanted.items():
            table = getattr(self, name)
            if not knots or nx != 2 * nq or table.shape != shape or not np.all(np.isfinite(table)) or not np.all(np.isfinite(self.flows)):
                raise ArrayError(f"observer.{name}", table, f"must hold finite numbers of shape {shape}", "give L, F and G at the same knots")

    def corrected(self, weights: tuple[int, int, float], expected: Vector, off: ArrayLike) -> Vector:
        """z (nx,) where `off` is w(y - q_r - C z_expected) (nq,); weights (j, k, f): a share f of the way from knot j to k."""
        return np.asarray(expected + _between(self.corrections, weights) @ np.asarray(off))

    def following(self, weights: tuple[int, int, float], z: Vector, pushed: Vector, sample: float) -> Vector:
        """z_expected (nx,) of the next call, after inputs that were u - u_r (nu,) off."""
        nq = len(z) // 2
        rates = z[nq:] + _between(self.flows, weights) @ z + _between(self.drives, weights) @ pushed
        return np.concatenate([z[:nq] + sample * (z[nq:] + rates) / 2, rates])


def _between(table: Vector, weights: tuple[int, int, float]) -> Vector:
    j, k, f = weights
    return np.asarray(table[j] + f * (table[k] - table[j]))
