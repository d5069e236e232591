"""What an observer along a trajectory finds out of parameters on the way, and how the chain is held with it."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from phichain.errors import ArrayError
from phichain.records import Held, held

Vector = NDArray[np.float64]

STILL: Final = 512
"""Steps of a sensor by which a reading that stays may be pulled before it counts as stuck."""
FORGOTTEN: Final = 0.25
"""Time after which a pull is forgotten, s: what a model is wrong by all the time must not add up."""


@dataclass(frozen=True, eq=False)
class Learning(Held):
    """theta, the relative errors of parameters, is estimated along the trajectory and known from its end on.

    Its entries are in the order of the chain's struct of parameters, without those that have no error; `names` says which they are. Along the trajectory theta = clip(theta_expected + M w(y - q_r - C z_expected), -b, b), and rates gain E theta in a sample beside F z + G (u - u_r). At
    the target theta stays what it is, rates gain

        (F + sum_k theta_k F_k) z + (G + sum_k theta_k G_k) (u - u_r),

    and a reading in steps of q corrects by two gains: what lies within half a step may be rounding, what lies beyond is none,

        z = z_expected + L_in c + L_out (e - c),    e = w(y - q_r - C z_expected),    c = clip(e, -q/2, q/2).

    A sensor that is stuck pulls the model along: while a reading stays the same to the bit, corrections take from the model what it says that
    the place moves by, and add up,

        r' = s (k r + z_v - z_v,expected),    p' = s (k p + z_q - z_q,expected + T r'),    k = 1 - T / FORGOTTEN,

    s = 1 where the reading stays and 0 where it changes. A sensor whose p is beyond STILL steps is taken for stuck.

    Attributes:
        learned: M (knots, np, nq), straight lines between the knots.
        pushes: E (knots, nq, np), likewise; none at the target, where the chain rests whatever its parameters are.
        bends: [F_k, G_k] (np, nq, nx + nu).
        steps: q (nq,), rad or m.
        inside: L_in (nx, nq).
        outside: L_out (nx, nq).
        bounds: b (np,), largest sizes of theta's entries.
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
    bounds: Vector
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
            "outside": (2 * nq, nq), "bounds": (count,),
        }  # fmt: skip
        for name, shape in wanted.items():
            table = getattr(self, name)
            if not knots or table.shape != shape or not np.all(np.isfinite(table)):
                raise ArrayError(f"learning.{name}", table, f"must hold finite numbers of shape {shape}", "give all of them of one chain")

        if not np.all(self.bounds > 0):
            raise ArrayError("learning.bounds", self.bounds, "must be positive", "give the largest relative errors that a parameter may have")
        if self.names and len(self.names) != count:
            raise ArrayError("learning.names", self.names, f"must be {count} of them", "give one for each parameter that is estimated")

    @property
    def count(self) -> int:
        """How many parameters are estimated."""
        return int(self.learned.shape[1])

    @property
    def kept(self) -> int:
        """Numbers that tell a sensor that is stuck: the readings, and r and p of each."""
        return 3 * len(self.steps)

    def pulled(self, before: Vector, y: Vector, corrections: Vector, sample: float) -> Vector:
        """(y, r', p') (3 nq,) at readings y (nq,), where `corrections` is z - z_expected (nx,)."""
        last, rate, place = before.reshape(3, -1)
        nq, keeps = len(y), forgetting(sample)
        stays = 1.0 - ((y < last) | (last < y))
        rate = stays * (keeps * rate + corrections[nq:])
        return np.concatenate([y, rate, stays * (keeps * place + corrections[:nq] + sample * rate)])

    def strain(self, kept: Vector) -> float:
        """The sum of the squares of p in STILL steps: above 1 where a sensor is stuck."""
        return float(np.sum((kept[2 * len(self.steps) :] / (STILL * self.steps)) ** 2))

    def corrected(self, expected: Vector, off: ArrayLike) -> Vector:
        """z (nx,) at the target, where `off` is w(y - q_r - C z_expected) (nq,)."""
        away = np.asarray(off, dtype=float)
        within = np.clip(away, -self.steps / 2, self.steps / 2)
        return np.asarray(expected + self.inside @ within + self.outside @ (away - within))

    def gained(self, theta: Vector, z: Vector, pushed: Vector) -> Vector:
        """What rates (nq,) gain in a sample at the target beside F z + G (u - u_r)."""
        return np.asarray(theta @ (self.bends @ np.concatenate([z, pushed])))


def forgetting(sample: float) -> float:
    """k, the share of a pull that is left after a sample."""
    return max(0.0, 1.0 - sample / FORGOTTEN)
