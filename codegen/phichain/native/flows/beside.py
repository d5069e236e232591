"""What says how large the errors of the Taylor flow are, in the compiled object alone: no generated folder has it.

A run leaves its steps; when somebody asks, neighbours of low order fly beside these, which costs a part of the run and nothing before.
A run of very many steps is judged on the way, so that they need not be kept.
"""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from phichain.native.memory.arrays import place

_CACHE_LINE: Final = 64
#: Bytes of steps that wait for somebody who asks: some 240 000 steps of two links in the plane, 25 000 of eight in space.
MOST_BYTES: Final = 2**26


@dataclass(frozen=True)
class Watched:
    """The flow that leaves its steps, and what flies beside them.

    Attributes:
        function: The foreign function: the arguments of the flow, whether it goes on, where it keeps what it goes on with, and where steps go.
        errors: The foreign function that takes them: parameters and input where the chain has any, a number of steps, the steps, the tolerance,
            where neighbours are kept, and where errors of angles and rates go.
        stop: Bytes of what a run goes on with.
        step: Numbers of one step but for coefficients of its rates: first how many rows of states were written up to its end, then how many
            coefficients follow for each rate.
        rates: How many rates there are.
        low: How many coefficients of each there are at most.
        room: Bytes that neighbours are kept in.
    """

    function: Any
    errors: Any
    stop: int
    step: int
    rates: int
    low: int
    room: int


class Desk:
    """Where a run in a frame leaves its steps, call after call.

    Attributes:
        arguments: The last arguments of the C.
    """

    def __init__(self, watched: Watched, most: int) -> None:
        """Room for so many steps."""
        self._watched, self._steps = watched, np.empty(most * (watched.step + watched.low * watched.rates))
        self._stop = np.zeros(watched.stop + _CACHE_LINE, np.uint8)
        self._goes_on = ctypes.c_int(0)
        self.arguments = (self._goes_on, ctypes.c_void_p(_aligned(self._stop)), ctypes.c_void_p(place(self._steps)))

    def go_on(self, whether: bool) -> None:
        """Whether the next call goes on with the last one as if that had not stopped."""
        self._goes_on.value = whether

    def taken(self, count: int) -> NDArray[np.float64]:
        """A copy of so many steps."""
        watched = self._watched
        size = watched.step + int(self._steps[1]) * watched.rates if count else watched.step
        return self._steps[: count * size].reshape(count, size).copy()


@dataclass(frozen=True)
class _Flown:
    """What neighbours have said so far.

    Attributes:
        rows: Errors in the rows of states, call by call (m, 2) each.
        last: Those where it ended (1, 2).
        room: Where the neighbours are.
    """

    rows: tuple[NDArray[np.float64], ...]
    last: NDArray[np.float64]
    room: NDArray[np.uint8]


_NOTHING: Final = _Flown((), np.zeros((1, 2)), np.empty(0, np.uint8))


class Beside:
    """The steps of one run, from call to call, and their errors once somebody asks, or once the steps take more than `MOST_BYTES`."""

    def __init__(self, watched: Watched) -> None:
        """None yet."""
        self.watched = watched
        self._pieces: list[NDArray[np.float64]] = []
        self._flown, self._waiting = _NOTHING, 0
        self._held: tuple[NDArray[Any], ...] = ()
        self._tolerance = 0.0
        self._errors: NDArray[np.float64] | None = None

    def keep(self, steps: NDArray[np.float64], held: tuple[NDArray[Any], ...], tolerance: float) -> None:
        """Keep the steps of a call.

        Args:
            steps: They.
            held: What stays the same for the whole run: parameters and input, as far as the chain has any.
            tolerance: What was kept, the same for the whole run, too.
        """
        self._held, self._tolerance = held, tolerance
        self._pieces.append(steps)
        self._waiting += steps.nbytes
        if self._waiting > MOST_BYTES:
            self._flown, self._pieces, self._waiting = self._further(self._pieces), [], 0

    @property
    def errors(self) -> NDArray[np.float64]:
        """The largest errors of entries of q and of v in the rows of states of the run, and where it ended (m + 1, 2).

        To be asked when the run is over: its steps are forgotten then.
        """
        pieces = self._pieces  # before another thread that finds the same can forget them
        if self._errors is None:
            flown = self._further(pieces)
            self._errors, self._pieces = np.concatenate((*flown.rows, flown.last)), []
        return self._errors

    def _further(self, pieces: Sequence[NDArray[np.float64]]) -> _Flown:
        """What they say after these steps, too; nothing is left half done by Ctrl-C."""
        watched, rows, last = self.watched, [*self._flown.rows], self._flown.last
        before, room = self._flown.room, np.zeros(watched.room + _CACHE_LINE, np.uint8)
        here = _aligned(room) - place(room)
        room[here : here + len(before)] = before
        held = [ctypes.c_void_p(place(array)) for array in self._held]
        for steps in pieces:
            errors = np.empty((len(steps), 2))
            watched.errors(
                *held, ctypes.c_ulong(len(steps)), ctypes.c_void_p(place(steps)), ctypes.c_double(self._tolerance),
                ctypes.c_void_p(_aligned(room)), ctypes.c_void_p(place(errors)),
            )  # fmt: skip
            rows.append(np.repeat(errors, np.diff(steps[:, 0], prepend=0.0).astype(int), axis=0))
            last = errors[-1:] if len(errors) else last
        return _Flown(tuple(rows), last, room[here : here + watched.room])


def _aligned(memory: NDArray[np.uint8]) -> int:
    return -(-place(memory) // _CACHE_LINE) * _CACHE_LINE
