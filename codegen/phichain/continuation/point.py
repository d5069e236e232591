"""One point of a branch, and the geometry it carries."""

from __future__ import annotations

from dataclasses import dataclass

from phichain.continuation.linear import null_vector
from phichain.continuation.problem import Extra, Multipliers, Problem
from phichain.records import Held
from phichain.system import Vector


@dataclass(frozen=True, eq=False)
class Point(Held):
    """A solution z of F(z) = 0 with the unit tangent of its curve, in scaled unknowns y = z / scale.

    Attributes:
        y: Scaled unknowns (n + 1,).
        tangent: Unit tangent dy/ds (n + 1,).
        arclength: s, from the start of the branch.
        jacobian: dF/dy (n, n + 1).
        residual: Relative residual.
        iterations: Newton iterations it took.
        corrections: Sizes of the Newton corrections, in order.
        extra: What came with the residual and the Jacobian.
    """

    y: Vector
    tangent: Vector
    arclength: float
    jacobian: Vector
    residual: float
    iterations: int
    corrections: tuple[float, ...]
    extra: Extra

    @property
    def multipliers(self) -> Multipliers:
        """Those of the solution (k,), as the problem's `Extra` has them; empty where it computes none."""
        return self.extra.multipliers

    def z(self, problem: Problem) -> Vector:
        """The unknowns themselves (n + 1,)."""
        return self.y * problem.sizes

    def slope(self, problem: Problem) -> Vector:
        """dz/ds (n + 1,)."""
        return self.tangent * problem.sizes


def tangent_of(jacobian: Vector, along: Vector) -> Vector:
    """Unit null vector of an (n, n + 1) Jacobian, turned towards `along`.

    It is the last column of Q in J^T = Q R: no unknown is singled out, so it exists at folds too.
    """
    null = null_vector(jacobian)
    return null if null @ along >= 0 else -null
