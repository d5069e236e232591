"""What flies beside the Taylor flow and says how large its errors are, in the compiled object alone: no generated folder has it."""

from __future__ import annotations

import ctypes
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from phichain.native.memory.arrays import place

_CACHE_LINE: Final = 64


@dataclass(frozen=True)
class Watched:
    """The flow with neighbours beside it.

    Attributes:
        function: The foreign function: the arguments of the flow, then where neighbours are kept and where errors go.
        size: Bytes that it keeps them in.
    """

    function: Any
    size: int


class Beside:
    """The neighbours of one run, which go on from call to call.

    Attributes:
        function: The foreign function.
    """

    def __init__(self, watched: Watched) -> None:
        """None yet."""
        self.function = watched.function
        self._room = np.zeros(watched.size + _CACHE_LINE, np.uint8)
        self._found, self._kept = np.zeros((1, 2)), list[NDArray[np.float64]]()

    def begin(self) -> None:
        """Forget what was found, for a propagation that goes on with the same neighbours."""
        self._kept = []

    def arguments(self, count: int) -> tuple[ctypes.c_void_p, ctypes.c_void_p]:
        """The last arguments of the C, for so many rows of states; a call of no step ends where the last one did."""
        last = self._found[-1]
        self._found = np.zeros((count + 1, 2))
        self._found[-1] = last
        return ctypes.c_void_p(-(-place(self._room) // _CACHE_LINE) * _CACHE_LINE), ctypes.c_void_p(place(self._found))

    def keep(self, written: int) -> None:
        """Keep what the C found in the rows that it has written."""
        self._kept.append(self._found[:written])

    @property
    def errors(self) -> NDArray[np.float64]:
        """The largest errors of entries of q and of v in the rows of states of the last propagation, and where it ended (m + 1, 2)."""
        return np.concatenate((*self._kept, self._found[-1:]))
