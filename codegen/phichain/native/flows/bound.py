"""The Taylor flow bound to its tolerance, its stop and its memory: checked once, then called for a few microseconds as often as wanted."""

from __future__ import annotations

import ctypes
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phichain.native.flows.motion import Frame
from phichain.system.propagation import OUTCOMES


class Bound:
    """One propagation after the other in the same memory, which the caller fills and reads; what C would not take is not looked for.

    A start that is not finite ends as "not finite". One Bound serves one thread at a time.

    Attributes:
        q: Configuration (nq,): the start before a call, the end after it.
        v: Rates (nv,), likewise.
        transition: Derivatives of (q, v) at the start (nq + nv, k), carried to the end; None where none are.
        outcome: How the last call ended: "done", "event", "step budget" or "not finite".
    """

    def __init__(self, frame: Frame, event: ctypes.Structure | None, transition: NDArray[Any] | None, budget: int) -> None:
        """Take a frame whose arguments are set, all but a start, its time and the end.

        Args:
            frame: It, for this record alone.
            event: Where to stop, which the frame's arguments point to.
            transition: Memory of the derivatives, which its struct points to.
            budget: Steps at most.
        """
        self.outcome, self.transition = "done", transition
        self._frame, self._event, self._budget = frame, event, budget
        self.q, self.v = frame.memory("q"), frame.memory("v")
        self._flow, self._t_end, self._max_steps = frame.flow, frame.given["t_end"], frame.given["max_steps"]
        self._arguments, self._brief = tuple(frame.given.values()), min(frame.brief, budget)
        self._function, self._briefly = frame.function, frame.briefly
        self._at, self._size = ctypes.addressof(frame.flow), ctypes.sizeof(frame.flow)
        self._begun = ctypes.string_at(self._at, self._size)
        self._before = 0

    def __call__(self, t: float, t_end: float) -> float:
        """Go from (q, v) at time t to t_end, or to where it stops.

        Returns:
            The time reached, s.

        Raises:
            TypeError: A time is no number.
        """
        flow = self._flow
        ctypes.memmove(self._at, self._begun, self._size)
        flow.t, self._t_end.value = t, t_end
        self._before, left = 0, self._budget
        if self._brief:
            self._max_steps.value = self._brief
            result = self._briefly(*self._arguments)
            left -= self._brief
            if result != _BUDGET or not left:
                self.outcome = OUTCOMES[result]
                return float(flow.t)
            self._before = flow.steps
        self._max_steps.value = left
        self.outcome = OUTCOMES[self._function(*self._arguments)]
        return float(flow.t)

    @property
    def context(self) -> tuple[Any, ...]:
        """What C code that calls the flow itself is given: the runtime parameters, if any, and the struct as it is before a call."""
        given = self._frame.given
        return tuple(given[name] for name in ("p", "flow") if name in given)

    @property
    def steps(self) -> int:
        """Steps of the last call."""
        return int(self._before + self._flow.steps)

    @property
    def lost(self) -> NDArray[np.float64]:
        """What rounding took from t and from the state (1 + nq + nv,)."""
        return self._frame.lost


_BUDGET = OUTCOMES.index("step budget")
