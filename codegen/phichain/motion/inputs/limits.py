"""Limits of inputs: what an amplifier or a motor gives at most."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from phichain.errors import ArrayError
from phichain.motion.inputs.names import position
from phichain.records import Held
from phichain.system import System, Vector
from phichain.system.arrays import reals

REMEDY = "give a number, (low, high), or one of the two for each input by name"


@dataclass(frozen=True, eq=False)
class Limits(Held):
    """low <= u <= high, entry by entry.

    Attributes:
        low: Least inputs (nu,); -inf for one without a limit.
        high: Largest inputs (nu,); inf for one without a limit.
    """

    low: Vector
    high: Vector

    def cut(self, u: Vector) -> Vector:
        """The inputs, saturated."""
        return np.clip(u, self.low, self.high)

    def of(self, at: tuple[int, ...]) -> Limits:
        """Those of some entries."""
        return Limits(self.low[list(at)], self.high[list(at)])


def as_limits(system: System, limit: Any) -> Limits | None:
    """Limits from what a caller gives: a number L for |u_j| <= L, a pair (low, high), or either by name; None for none.

    Raises:
        ArrayError: No numbers, no room between them, an unknown name, or a system without inputs.
    """
    if limit is None:
        return None
    if system.nu == 0:
        raise ArrayError("limit", limit, "is given to a system that has no input", "leave limit out")
    if not isinstance(limit, Mapping):
        return Limits(*_pair("limit", limit, system.nu))
    low, high = np.full(system.nu, -np.inf), np.full(system.nu, np.inf)
    for name, given in limit.items():
        k = position(system, "limit", name)
        (low[k],), (high[k],) = _pair(f"limit.{name}", given, 1)
    return Limits(low, high)


def _pair(field: str, given: Any, size: int) -> tuple[Vector, Vector]:
    bounds = given if isinstance(given, tuple) and len(given) == 2 else (None, given)
    high = reals(field, bounds[1], REMEDY)
    low = -high if bounds[0] is None else reals(field, bounds[0], REMEDY)
    if any(bound.shape not in ((), (size,)) for bound in (low, high)) or (bounds[0] is None and high.ndim):
        raise ArrayError(field, given, f"is neither a number nor a pair of numbers or of {size}", REMEDY)
    if not (low < high).all():
        raise ArrayError(field, given, "leaves nothing between its two ends", "give a lower limit below the upper one")
    return np.full(size, low), np.full(size, high)
