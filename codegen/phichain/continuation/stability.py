"""Which solutions of a branch are stable, as their multipliers say."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from phichain.continuation.problem import Multipliers

_CLOSE = 1e-6
"""How far kappa may lie off the interval from -1 to 1: where it touches an end, rounding puts it beyond."""


def are_stable(kappa: Multipliers) -> NDArray[np.bool_]:
    """Whether every kappa = (mu + 1/mu) / 2 of a point is real and between -1 and 1, all mu then lying on the unit circle; (m, k) -> (m,)."""
    inside = (np.abs(kappa.imag) <= _CLOSE) & (np.abs(kappa.real) <= 1 + _CLOSE)
    return np.asarray(np.all(inside, axis=1))
