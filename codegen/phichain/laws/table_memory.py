"""What a table with observers or integrals keeps from one call to the next."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class TableMemory:
    """What a table keeps from one call to the next.

    Attributes:
        held: Which equilibrium is held, -1 for none.
        near: About which one the deviation is, -1 for none.
        calls: Calls in a row that found its level low enough to be taken up.
        level: The level that decided last.
        deviation: Before a call the deviation that is expected (n,), after the supervisor what it is taken for.
        integral: Integrals of what is held (ni,).
    """

    held: int
    near: int
    calls: int
    level: float
    deviation: Vector
    integral: Vector
