"""Events: test functions along a branch whose sign changes are located.

A test is a small record with a name, a `value` at a point and `terminal`, whether the run ends there.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final, Protocol

import numpy as np

from phichain.continuation.compiled.protocol import Watch
from phichain.continuation.linear import bordered, least_singular_value, sign_of_determinant
from phichain.continuation.point import Point
from phichain.continuation.problem import Problem
from phichain.system import Vector

ENERGY: Final = ("energy", 0)
"""What a compiled problem calls the scalar that it records."""
SINGULAR: Final = "sigma"
"""What it calls the smallest singular value of [J; t]."""


class TestFunction(Protocol):
    """What every test function offers."""

    @property
    def name(self) -> str:
        """How its zeros are called."""
        ...

    @property
    def terminal(self) -> bool:
        """True when the run ends at its first zero."""
        ...

    def value(self, problem: Problem, point: Point) -> float:
        """The test function; its simple zeros are the events."""
        ...


@dataclass(frozen=True)
class Fold:
    """Turning point of one unknown: its component of the tangent vanishes.

    Attributes:
        component: Index of the unknown; None means the problem's parameter.
    """

    component: int | None = None
    name: str = "fold"
    terminal: bool = False

    def value(self, problem: Problem, point: Point) -> float:
        """dz_i/ds in scaled unknowns."""
        return float(point.tangent[problem.parameter if self.component is None else self.component])


@dataclass(frozen=True)
class BranchPoint:
    """Crossing of two branches: det [J; t^T] changes sign (Keller 1977).

    The value is the smallest singular value of [J; t^T] under the determinant's sign: it has the same zeros,
    crosses them linearly, and neither overflows nor underflows with the number of equations.

    Attributes:
        ends: Whether the run ends at such a point, where that depends on it.
    """

    name: str = "branch point"
    terminal: bool = False
    ends: Callable[[Problem, Point], bool] | None = None

    def value(self, problem: Problem, point: Point) -> float:
        """+- the smallest singular value of the Jacobian bordered by the tangent."""
        return signed(bordered(point.jacobian, point.tangent)) if point.sigma is None else point.sigma


@dataclass(frozen=True)
class Level:
    """A scalar of the unknowns reaches a value.

    Attributes:
        scalar: z (n + 1,) -> number.
        level: The value.
        held: z near it -> the unknown that has to have which value there, so that the run ends exactly on it;
            None where the level is no matter of one unknown.
        of: What a compiled problem calls the scalar, and which one of these it is.
    """

    scalar: Callable[[Vector], float]
    level: float
    name: str = "level"
    terminal: bool = True
    held: Callable[[Vector], tuple[int, float]] | None = None
    of: tuple[str, int] | None = None

    def value(self, problem: Problem, point: Point) -> float:
        """scalar(z) - level."""
        if self.of == ENERGY and not math.isnan(point.energy):
            return point.energy - self.level
        return float(self.scalar(point.z(problem))) - self.level


@dataclass(frozen=True)
class Extremum:
    """A scalar of the unknowns is stationary along the branch (the energy of a family of orbits, say).

    Attributes:
        scalar: z (n + 1,) -> number.
        width: Arclength over which it is differenced.
    """

    scalar: Callable[[Vector], float]
    name: str = "extremum"
    width: float = 1e-4
    terminal: bool = False

    def value(self, problem: Problem, point: Point) -> float:
        """d scalar / ds by a central difference along the tangent, exact to the second order in the width."""
        z, slope = point.z(problem), point.slope(problem)
        ahead, behind = self.scalar(z + self.width * slope), self.scalar(z - self.width * slope)
        return float(ahead - behind) / (2 * self.width)


@dataclass(frozen=True)
class Quantity:
    """A smooth number that the method knows of every point.

    Attributes:
        of: Point -> number.
        in_pairs: Whether it is nearly a square where it comes to zero, so that it is looked at where that would vanish, too.
        order: Point -> labels whose order changes from one point to another of one sign exactly where two
            zeros lie between; None where it has none.
        ends: Whether the run ends at such a zero, where that depends on it.
        known: What a compiled problem calls it, empty where it does not know it, ...
        less: ... and what is taken off.
    """

    of: Callable[[Point], float]
    name: str
    terminal: bool = False
    in_pairs: bool = False
    order: Callable[[Point], tuple[int, ...] | None] | None = None
    ends: Callable[[Problem, Point], bool] | None = None
    known: str = ""
    less: float = 0.0

    def value(self, problem: Problem, point: Point) -> float:
        """The number itself."""
        return self.of(point)


def watch_of(problem: Problem, test: TestFunction) -> Watch:
    """A test function as a compiled problem takes it; of nothing where it is none of its own."""
    if isinstance(test, Fold):
        return Watch("tangent", (problem.parameter if test.component is None else test.component) % problem.unknowns, 0.0, 2, not test.terminal)
    if isinstance(test, BranchPoint):
        return Watch(SINGULAR, 0, 0.0, 0)
    if isinstance(test, Level) and test.of is not None:
        return Watch(*test.of, test.level, 0)
    if isinstance(test, Quantity) and not test.in_pairs and test.order is None:
        return Watch(test.known, 0, test.less, 1, not (test.terminal or test.ends is not None))
    return Watch("", 0, 0.0, 0)


def signed(matrix: Vector) -> float:
    """+- the smallest singular value of a square matrix, its sign that of the determinant: simple zeros where
    that has some. NaN where it is no numbers, as where a curve is looked for and a motion cannot be followed."""
    if matrix.shape == (2, 2):
        (a, b), (c, d) = matrix.tolist()
        determinant, squares = a * d - b * c, a * a + b * b + c * c + d * d
        largest = math.sqrt((squares + math.sqrt(max(0.0, (squares - 2 * determinant) * (squares + 2 * determinant)))) / 2)
        return determinant / largest if largest > 0 else determinant
    try:
        return sign_of_determinant(matrix) * least_singular_value(matrix)
    except np.linalg.LinAlgError:
        return math.nan
