"""Results of C in double precision, which nobody can write to."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

_WIDE: Final = np.dtype(np.float64)


def wide(array: NDArray[Any]) -> NDArray[np.float64]:
    """A result in double precision, of its own, that nobody can write to."""
    copy = array.copy() if array.dtype is _WIDE else array.astype(np.float64)
    copy.setflags(write=False)
    return copy


def kept_wide(array: NDArray[Any]) -> NDArray[np.float64]:
    """The same of an array that nobody else has: itself, if it is of double precision."""
    if array.dtype is not _WIDE:
        return wide(array)
    array.setflags(write=False)
    return array
