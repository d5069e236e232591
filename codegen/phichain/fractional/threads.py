"""Threads of the fractional operators, and products that keep to the one that asks for them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from phichain.system.threads import available_cores, run

__all__ = ["available_cores", "product", "run"]

Vector = NDArray[np.float64]

# OpenBLAS starts its own threads from about 2^20 multiplications on.
_ONE_THREAD = 2**19


def product(left: Vector, right: Vector, out: Vector | None = None) -> Vector:
    """left @ right in pieces so small that BLAS keeps to the calling thread.

    Its own threads would compete with those of `run`, and they spin while they wait: on a busy machine a small product
    takes ten times as long with them.
    """
    if out is None:
        out = np.empty((left.shape[0], right.shape[1]))
    columns = max(1, _ONE_THREAD // max(1, left.size))
    for first in range(0, right.shape[1], columns):
        piece = slice(first, first + columns)
        np.matmul(left, right[:, piece], out=out[:, piece])
    return out
