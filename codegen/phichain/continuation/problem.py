"""The continuation problem: n equations F(z) = 0 in n + 1 unknowns, whose solutions form curves.

No unknown is singled out while a curve is followed; `parameter` only names the one whose turning points are
called folds.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from phichain.errors import ArrayError
from phichain.system import Vector
from phichain.system.arrays import reals


@dataclass(frozen=True, eq=False)
class Problem:
    """F: R^(n+1) -> R^n with its exact Jacobian.

    Attributes:
        residual: z (n + 1,) -> F (n,).
        jacobian: z (n + 1,) -> dF/dz (n, n + 1).
        names: Names of the n + 1 unknowns.
        scale: Typical sizes of the unknowns (n + 1,); arclength is measured in z / scale. None means ones.
        parameter: The unknown whose turning points are called folds; the last one unless said otherwise.
        energy: A scalar of z recorded along the branch, or None.
    """

    residual: Callable[[Vector], Vector]
    jacobian: Callable[[Vector], Vector]
    names: tuple[str, ...]
    scale: Vector | None = None
    parameter: int = -1
    energy: Callable[[Vector], float] | None = None

    def __post_init__(self) -> None:
        sizes = np.ones(len(self.names)) if self.scale is None else reals("scale", self.scale, "give one typical size per unknown")
        if sizes.shape != (len(self.names),) or not np.all(np.isfinite(sizes) & (sizes > 0)):
            raise ArrayError(
                "scale",
                self.scale,
                f"must hold {len(self.names)} positive sizes",
                "give one typical size per unknown",
            )
        object.__setattr__(self, "scale", sizes)
        if not -len(self.names) <= self.parameter < len(self.names):
            raise ArrayError(
                "parameter", self.parameter, "names no unknown", f"use 0 .. {len(self.names) - 1}"
            )

    @property
    def unknowns(self) -> int:
        """n + 1."""
        return len(self.names)

    @property
    def sizes(self) -> Vector:
        """`scale` as an array, ones by default; shape (n + 1,)."""
        assert self.scale is not None
        return self.scale

    def check(self, z: Vector) -> Vector:
        """A starting point of the right shape at which residual and Jacobian have theirs.

        Raises:
            ArrayError: A shape is wrong, or z is not finite.
        """
        names, n = ", ".join(self.names), self.unknowns - 1
        start = np.array(reals("start", z, f"give {names}"))
        if start.shape != (n + 1,) or not np.all(np.isfinite(start)):
            raise ArrayError("start", z, f"must hold {n + 1} finite numbers", f"give {names}")
        residual, jacobian = np.shape(self.residual(start)), np.shape(self.jacobian(start))
        if residual != (n,) or jacobian != (n, n + 1):
            raise ArrayError(
                "problem",
                (residual, jacobian),
                f"residual and Jacobian must have shapes ({n},) and ({n}, {n + 1})",
                "count the equations: one fewer than unknowns",
            )
        return start


def relative_residual(residual: Vector, jacobian: Vector, z: Vector) -> float:
    """max_i |F_i| / sum_j |J_ij| |z_j|: the residual in units of the terms it is the difference of.

    Values near the unit round-off, 1.1e-16, are as good as the arithmetic allows.
    """
    terms = np.abs(jacobian) @ np.abs(z)
    safe = np.where(terms > 0, terms, 1.0)
    return float(np.max(np.abs(residual) / safe, initial=0.0))
