"""Correctors: from a predicted point back to the curve.

A corrector is any callable `(problem, guess, normal, options) -> Correction`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from phichain.continuation.linear import are_finite, bordered, size, solve
from phichain.continuation.options import Options
from phichain.continuation.point import Point, tangent_of
from phichain.continuation.problem import Extra, Problem, relative_residual
from phichain.records import Held
from phichain.system import Vector


@dataclass(frozen=True, eq=False)
class Correction(Held):
    """Where Newton's iteration ended.

    Attributes:
        y: Last iterate (n + 1,), scaled.
        jacobian: dF/dy there (n, n + 1).
        residual: Relative residual there.
        corrections: Sizes of the corrections, in order.
        converged: True when the last one was below the tolerance.
        extra: What came with the residual and the Jacobian there.
        tangent: Unit null vector of the Jacobian, either way (n + 1,); None where nobody has asked.
        sigma: +- the smallest singular value of [J; t] with it.
        is_settled: Whether the Jacobian is that of this very place.
        energy: The scalar that the problem records, NaN where it is not known with the rest.
    """

    y: Vector
    jacobian: Vector
    residual: float
    corrections: tuple[float, ...]
    converged: bool
    extra: Extra
    tangent: Vector | None = None
    sigma: float | None = None
    is_settled: bool = True
    energy: float = math.nan

    @property
    def iterations(self) -> int:
        """Newton iterations taken."""
        return len(self.corrections)

    def point(self, along: Vector, arclength: float) -> Point:
        """The last iterate as a point of its curve, its tangent turned towards `along`."""
        tangent, sigma = self.tangent, self.sigma
        if tangent is None:
            tangent = tangent_of(self.jacobian, along)
        elif tangent @ along < 0:
            tangent, sigma = -tangent, None if sigma is None else -sigma
        return Point.made(
            y=self.y, tangent=tangent, arclength=arclength, jacobian=self.jacobian, residual=self.residual,
            iterations=len(self.corrections), corrections=self.corrections, extra=self.extra, sigma=sigma, is_settled=self.is_settled, energy=self.energy,
        )  # fmt: skip


Corrector = Callable[[Problem, Vector, Vector, Options], Correction]
ROUNDING = 1e-15
"""Corrections, in units of 1 + |y|, that are not worth taking where the residual is rounding, too."""
EPS = float(np.finfo(float).eps)


def pseudo_arclength(problem: Problem, guess: Vector, normal: Vector, options: Options) -> Correction:
    """Newton on F(y) = 0 together with normal . (y - guess) = 0 (Keller 1977), with the exact Jacobian."""
    if problem.compiled is not None:
        return Correction.made(**problem.compiled.corrected(guess, normal, options.tol, options.trust, options.max_iterations))

    def step(residual: Vector, jacobian: Vector, y: Vector) -> Vector:
        left = np.empty(len(y))
        left[:-1], left[-1] = residual, normal @ (y - guess)
        return -solve(bordered(jacobian, normal), left)

    return _newton(problem, guess, step, options)


def moore_penrose(problem: Problem, guess: Vector, normal: Vector, options: Options) -> Correction:
    """Gauss-Newton: the shortest correction onto F = 0, y <- y - J^+ F (Allgower and Georg 1990); needs no normal."""

    def step(residual: Vector, jacobian: Vector, y: Vector) -> Vector:
        correction = np.linalg.lstsq(jacobian, -residual, rcond=None)[0]
        return np.asarray(correction, dtype=float)

    return _newton(problem, guess, step, options)


def _newton(
    problem: Problem, guess: Vector, step: Callable[[Vector, Vector, Vector], Vector], options: Options
) -> Correction:
    y = guess.copy()
    residual, jacobian, extra = problem.at(y)
    sizes: list[float] = []
    converged = False
    while not converged and _is_worth_it(residual, sizes):
        try:
            correction = step(residual, jacobian, y)
        except np.linalg.LinAlgError:
            break
        length, scale = size(correction), 1 + size(y)
        # What is left to correct is known already: where it is rounding, nothing is asked again to see that.
        converged = length <= ROUNDING * scale and relative_residual(residual, jacobian, y) <= EPS
        if converged or len(sizes) == options.max_iterations:
            break
        y = y + correction
        sizes.append(length)
        if converged := length <= options.trust * scale:
            residual = residual + jacobian @ correction
            break
        residual, jacobian, extra = problem.at(y)
        converged = length <= options.tol * scale
    finite = are_finite(jacobian) and are_finite(residual)
    left = relative_residual(residual, jacobian, y) if finite else float("inf")
    return Correction.made(
        y=y, jacobian=jacobian, residual=left, corrections=tuple(sizes), converged=converged and finite, extra=extra,
        tangent=None, sigma=None, is_settled=True, energy=math.nan,
    )  # fmt: skip


def _is_worth_it(residual: Vector, sizes: list[float]) -> bool:
    """False once Newton has left the numbers or its corrections grow: a smaller step is cheaper than hoping."""
    growing = len(sizes) >= 2 and sizes[-1] > 2 * sizes[-2]
    return are_finite(residual) and not growing
