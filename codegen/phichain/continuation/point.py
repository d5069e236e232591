"""One point of a branch, and the geometry it carries."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from phichain.continuation.linear import null_vector
from phichain.continuation.problem import Extra, Multipliers, Problem, relative_residual
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
        sigma: +- the smallest singular value of the Jacobian bordered by the tangent, its sign the determinant's; None where nobody has asked.
        is_settled: Whether Jacobian and tangent are those of this very place.
        energy: The scalar that the problem records (`Problem.energy`), where it is known with the point; NaN where it is not.
    """

    y: Vector
    tangent: Vector
    arclength: float
    jacobian: Vector
    residual: float
    iterations: int
    corrections: tuple[float, ...]
    extra: Extra
    # By factories, so that the class itself has none of them: a point that waits to be asked (`block.BlockPoint`) hears of all.
    sigma: float | None = field(default_factory=lambda: None)
    is_settled: bool = field(default_factory=lambda: True)
    energy: float = field(default_factory=lambda: math.nan)

    @property
    def multipliers(self) -> Multipliers:
        """Those of the solution (k,), as the problem's `Extra` has them; empty where it computes none."""
        return self.extra.multipliers

    def z(self, problem: Problem) -> Vector:
        """The unknowns themselves (n + 1,)."""
        own = vars(self)
        if "_z" not in own:
            own["_z"] = self.y * problem.sizes
        z: Vector = own["_z"]
        return z

    def slope(self, problem: Problem) -> Vector:
        """dz/ds (n + 1,)."""
        return self.tangent * problem.sizes


@dataclass(frozen=True, eq=False)
class Reached(Held):
    """Where a run has come to, as it is told on the way.

    Attributes:
        names: Names of the unknowns.
        z: The unknowns themselves (n + 1,).
        arclength: s, from the start of the branch.
    """

    names: tuple[str, ...]
    z: Vector
    arclength: float


def tangent_of(jacobian: Vector, along: Vector) -> Vector:
    """Unit null vector of an (n, n + 1) Jacobian, turned towards `along`.

    It is the last column of Q in J^T = Q R: no unknown is singled out, so it exists at folds too.
    """
    null = null_vector(jacobian)
    return null if null @ along >= 0 else -null


def point_at(problem: Problem, y: Vector, along: Vector, arclength: float, iterations: int, *, settle: bool = False) -> Point:
    """The point at scaled unknowns (n + 1,), its tangent turned towards `along`.

    Args:
        problem: What is continued.
        y: Scaled unknowns (n + 1,).
        along: Where the tangent is to point.
        arclength: s there.
        iterations: Newton iterations it took.
        settle: Whether what Newton still finds to be wrong is taken off, where that costs no more.

    Raises:
        LinAlgError: The problem is no numbers there.
    """
    if problem.compiled is not None:
        told = (problem.compiled.settled if settle else problem.compiled.at)(y, along)
        if told is not None:
            kept = {name: told[name] for name in ("y", "tangent", "jacobian", "residual", "extra", "sigma", "energy")}
            return Point.made(**kept, arclength=arclength, iterations=iterations, corrections=(), is_settled=True)
    residual, jacobian, extra = problem.at(y)
    return Point(y, tangent_of(jacobian, along), arclength, jacobian, relative_residual(residual, jacobian, y), iterations, (), extra)
