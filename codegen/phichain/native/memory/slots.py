"""Preallocated memory that C reads, filled without a detour by what needs no conversion."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from phichain.native.memory.arrays import SCALAR


@dataclass
class Slot:
    """A piece of it.

    Attributes:
        shape: The shape of its values.
        values: The memory.
        entries: The same memory as ctypes fills it from a list; None unless it is a vector.
    """

    shape: tuple[int, ...]
    values: NDArray[Any]
    entries: Any

    def take(self, value: Any) -> bool:
        """Copy an array of this shape and no wider type, a list of Python's numbers, or a number for a scalar.

        Returns:
            Whether it was one of these; all else is left to those who convert it, or say what is wrong with it.
        """
        if type(value) is np.ndarray:
            if value.shape != self.shape or not _is_no_wider(value.dtype, self.values.dtype):
                return False
            self.values[...] = value
            return True
        try:
            if not self.shape and isinstance(value, float | int):
                self.values[...] = value
                return True
            if self.entries is None or type(value) not in _LISTS or not _NUMBERS.issuperset(map(type, value)):
                return False
            self.entries[:] = value
        except (OverflowError, ValueError):  # a whole number that no double holds; another length
            return False
        return True


def slot(shape: tuple[int, ...], values: NDArray[Any]) -> Slot:
    """The slot of aligned, packed memory."""
    vector = len(shape) == 1
    return Slot(shape, values, (SCALAR[values.dtype.name] * len(values)).from_buffer(values) if vector else None)


def _is_no_wider(given: np.dtype[Any], kind: np.dtype[Any]) -> bool:
    """Whether copying needs no leave and causes no warning."""
    return given.kind in "biu" or given.kind == "f" and given.itemsize <= kind.itemsize


_LISTS: Final = (list, tuple)
_NUMBERS: Final = frozenset((float, int, np.float64))
