"""What an observer along a trajectory finds out of parameters on the way, and how the chain is held with it."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import ArrayLike, NDArray

from phichain.errors import ArrayError
from phichain.records import Held, held

Vector = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Learning(Held):
    """theta, the relative errors of parameters, is estimated along the trajectory and known from its end on.

    Its entries are in the order of the chain's struct of parameters, without those that have no error; `names` says which they are. Along the trajectory theta = theta_expected + M w(y - q_r - C z_expected), and rates gain E theta in a sample beside F z + G (u - u_r). At the
    target theta stays what it is, rates gain

        (F + sum_k theta_k F_k) z + (G + sum_k theta_k G_k) (u - u_r),

    and a reading in steps of q corrects by two gains: what lies within half a step may be rounding, what lies beyond is none,

        z = z_expected + L_in c + L_out (e - c),    e = w(y - q_r - C z_expected),    c = clip(e, -q/2, q/2).

    Attributes:
        learned: M (knots, np, nq), straight lines between the knots.
        pushes: E (knots, nq, np), likewise; none at the target, where the chain rests whatever its parameters are.
        bends: [F_k, G_k] (np, nq, nx + nu).
        steps: q (nq,), rad or m.
        inside: L_in (nx, nq).
        outside: L_out (nx, nq).
        names: What theta's entries are errors of (np,), such as mass_1; none where nobody has said.

    Raises:
        ArrayError: Shapes that do not fit one another, or numbers that are not finite.
    """

    learned: Vector
    pushes: Vector
    bends: Vector
    steps: Vector
    inside: Vector
    outside: Vector
    names: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "names", tuple(self.names))
        for one in fields(self):
            if one.name != "names":
                object.__setattr__(self, one.name, held(getattr(self, one.name)))
        knots, count, nq = self.learned.shape if self.learned.ndim == 3 else (0, 0, 0)
        wide = self.bends.shape[-1] if self.bends.ndim else 0
        wanted = {
            "learned": (knots, count, nq), "pushes": (knots, nq, count), "bends": (count, nq, wide), "steps": (nq,), "inside": (2 * nq, nq),
            "outside": (2 * nq, nq),
        }  # fmt: skip
        for name, shape in wanted.items():
            table = getattr(self, name)
            if not knots or table.shape != shape or not np.all(np.isfinite(table)):
                raise ArrayError(f"learning.{name}", table, f"must hold finite numbers of shape {shape}", "give all of them of one chain")

        if self.names and len(self.names) != count:
            raise ArrayError("learning.names", self.names, f"must be {count} of them", "give one for each parameter that is estimated")

    @property
    def count(self) -> int:
        """How many parameters are estimated."""
        return int(self.learned.shape[1])

    def corrected(self, expected: Vector, off: ArrayLike) -> Vector:
        """z (nx,) at the target, where `off` is w(y - q_r - C z_expected) (nq,)."""
        away = np.asarray(off, dtype=float)
        within = np.clip(away, -self.steps / 2, self.steps / 2)
        return np.asarray(expected + self.inside @ within + self.outside @ (away - within))

    def gained(self, theta: Vector, z: Vector, pushed: Vector) -> Vector:
        """What rates (nq,) gain in a sample at the target beside F z + G (u - u_r)."""
        return np.asarray(theta @ (self.bends @ np.concatenate([z, pushed])))
