"""The continuation problem: n equations F(z) = 0 in n + 1 unknowns, whose solutions form curves.

No unknown is singled out while a curve is followed; `parameter` only names the one whose turning points are
called folds. One evaluation gives the residual, its Jacobian and whatever else came with them: a propagation over a
period, say, has the multipliers of the orbit in the same columns as the Jacobian.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from phichain.continuation.compiled.protocol import Compiled
from phichain.errors import ArrayError
from phichain.records import Held, held
from phichain.system import Vector
from phichain.system.arrays import reals

Multipliers = NDArray[np.complex128]
_CLOSE = 1e-6
"""How far kappa may lie off the interval from -1 to 1: where it touches an end, rounding puts it beyond."""


@dataclass(frozen=True, eq=False)
class Extra(Held):
    """What came with a residual and its Jacobian, besides them.

    Attributes:
        multipliers: Complex numbers (k,) that tell the stability of the solution, in the form that the method states:
            Floquet's lambda, or kappa = (mu + 1/mu) / 2 with lambda = mu^2 where symmetry halves the period. As many at
            every point; empty where the method computes none.
        found: Whatever else the method knows of the solution; its own tests read it.

    Raises:
        ArrayError: The multipliers are no vector of numbers.
    """

    multipliers: Multipliers = field(default_factory=lambda: held((), complex))
    found: Any = field(default_factory=lambda: None)

    def __post_init__(self) -> None:
        try:
            multipliers = held(self.multipliers, complex)
        except (TypeError, ValueError):
            multipliers = None
        if multipliers is None or multipliers.ndim != 1:
            raise ArrayError(
                "extra.multipliers", self.multipliers, "is no vector of complex numbers", "give shape (k,), or leave it out"
            )
        object.__setattr__(self, "multipliers", multipliers)


class LateExtra(Extra):
    """Multipliers and what else is found, made when they are first asked for: not at Newton's iterates on the way."""

    def __init__(self, make: Callable[[], tuple[Multipliers, Any]]) -> None:
        """Keep what makes both."""
        self.__dict__["_make"] = make

    def __getattr__(self, name: str) -> Any:
        """Either of both when it is first read; from then on they are attributes as of any `Extra`.

        Raises:
            AttributeError: There is no such field.
        """
        if name not in ("multipliers", "found"):
            raise AttributeError(name)
        self.__dict__.update(self._made(name))
        return self.__dict__[name]

    def _made(self, _: str) -> dict[str, Any]:
        """The one that is asked for, and the other where that comes with it."""
        multipliers, found = self.__dict__["_make"]()
        return {"multipliers": held(multipliers, complex), "found": found}


class Evaluation(NamedTuple):
    """A problem at one z: F (n,), its Jacobian (n, n + 1), and what came with them."""

    residual: Vector
    jacobian: Vector
    extra: Extra = Extra()


@dataclass(frozen=True, eq=False)
class Problem:
    """F: R^(n+1) -> R^n with its exact Jacobian.

    Attributes:
        evaluate: z (n + 1,) -> (F (n,), dF/dz (n, n + 1), extra): everything that is known at z, in one call.
        names: Names of the n + 1 unknowns.
        scale: Typical sizes of the unknowns (n + 1,); arclength is measured in z / scale. None means ones.
        parameter: The unknown whose turning points are called folds; the last one unless said otherwise.
        energy: A scalar of z recorded along the branch, or None.
        error: A Point of the branch -> what the method believes to be wrong with it, relative; None where it cannot say.
        compiled: Whole iterations on it in C, None where there are none.

    Raises:
        ArrayError: `scale` or `parameter` does not fit the names.
    """

    evaluate: Callable[[Vector], Evaluation]
    names: tuple[str, ...]
    scale: Vector | None = None
    parameter: int = -1
    energy: Callable[[Vector], float] | None = None
    error: Callable[[Any], float] | None = None
    compiled: Compiled | None = None

    def __post_init__(self) -> None:
        remedy = "give one typical size per unknown"
        sizes = held(np.ones(len(self.names)) if self.scale is None else reals("scale", self.scale, remedy))
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

    def at(self, y: Vector) -> Evaluation:
        """F, dF/dy and what came with them at z = y * sizes, y the scaled unknowns (n + 1,)."""
        sizes = self.sizes
        residual, jacobian, extra = self.evaluate(y * sizes)
        return Evaluation(np.asarray(residual, dtype=float), np.asarray(jacobian, dtype=float) * sizes, extra)

    def check(self, z: Vector) -> Vector:
        """A starting point of the right shape at which residual and Jacobian have theirs.

        Raises:
            ArrayError: A shape is wrong, z is not finite, or `evaluate` gives no (F, J, extra).
        """
        names, n = ", ".join(self.names), self.unknowns - 1
        start = np.array(reals("start", z, f"give {names}"))
        if start.shape != (n + 1,) or not np.all(np.isfinite(start)):
            raise ArrayError("start", z, f"must hold {n + 1} finite numbers", f"give {names}")
        found = self.evaluate(start)
        if not isinstance(found, Evaluation) or not isinstance(found.extra, Extra):
            raise ArrayError(
                "problem", found, "evaluate must give (F, J, extra)", "return Evaluation(residual, jacobian)"
            )
        residual, jacobian = np.shape(found.residual), np.shape(found.jacobian)
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
    terms = (np.abs(jacobian) @ np.abs(z)).tolist()
    return max((abs(left) / (term if term > 0 else 1.0) for left, term in zip(residual.tolist(), terms, strict=True)), default=0.0)


def are_stable(kappa: Multipliers) -> NDArray[np.bool_]:
    """Whether every kappa = (mu + 1/mu) / 2 of a point is real and between -1 and 1, all mu then lying on the unit circle; (m, k) -> (m,)."""
    inside = (np.abs(kappa.imag) <= _CLOSE) & (np.abs(kappa.real) <= 1 + _CLOSE)
    return np.asarray(np.all(inside, axis=1))
