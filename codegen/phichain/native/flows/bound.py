"""The Taylor flow bound to its tolerance, its stop and its memory: checked once, then called for a microsecond as often as wanted.

What a call from Python costs is what it hands over: here one address, behind which all else stays.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phichain.contract.chain import Chain
from phichain.contract.flow import Field, Struct
from phichain.contract.flows import PROPAGATE
from phichain.native.flows.motion import Frame
from phichain.system.propagation import OUTCOMES

Go = Callable[[ctypes.c_void_p], float]
"""Steps within a struct of `bound_struct` from its `t` on: returns where they ended, or no number if there may be more to do."""


def bound_struct(chain: Chain) -> Struct:
    """What a call is given, told to and told of: the span, the flow as it is before a call, and every argument of the flow."""
    own = (
        Field("t", "real"), Field("brief", "unsigned long"), Field("begun", "flow", is_pointer=True), Field("steps", "unsigned long"),
        Field("outcome", "int"),
    )  # fmt: skip
    handed = (Field(argument.name, argument.type, is_pointer=argument.form != "value") for argument in PROPAGATE.arguments_of(chain))
    return Struct("bound", (*own, *handed), remarks_at=0)


class Bound:
    """One propagation after the other in the same memory, which the caller fills and reads; what C would not take is not looked for.

    A start that is not finite ends as "not finite". One Bound serves one thread at a time.

    Attributes:
        state: All that moves in one vector: q, v and, where derivatives are carried, `transition` row by row. A caller who has it so fills it at once.
        q: Configuration (nq,), a part of it: the start before a call, the end after it.
        v: Rates (nv,), likewise.
        transition: Derivatives of (q, v) at the start (nq + nv, k), carried to the end, likewise; None where none are.
    """

    def __init__(self, frame: Frame, event: ctypes.Structure | None, given: ctypes.Structure, go: Go, budget: int) -> None:
        """Take a frame whose arguments are set, all but a start, its time and the end.

        Args:
            frame: It, for this record alone.
            event: Where to stop, which the frame's arguments point to.
            given: A struct of `bound_struct` without anything in it yet.
            go: What takes its address.
            budget: Steps at most.
        """
        self._frame, self._event, self._given, self._go = frame, event, given, go
        self.state, self.transition, self.q, self.v = frame.moving, frame.columns, frame.memory("q"), frame.memory("v")
        self._begun = type(frame.flow).from_buffer_copy(frame.flow)
        for name, value in frame.given.items():
            setattr(given, name, value.value)
        given.brief, given.begun = min(frame.brief, budget), ctypes.addressof(self._begun)
        self._left = budget - given.brief
        self._at = ctypes.c_void_p(ctypes.addressof(given))

    def __call__(self, t: float, t_end: float) -> float:
        """Go from (q, v) at time t to t_end, or to where it stops.

        Returns:
            The time reached, s.

        Raises:
            TypeError: A time is no number.
        """
        given = self._given
        given.t, given.t_end = t, t_end
        reached = self._go(self._at)
        return reached if reached == reached else self._further()  # noqa: PLR0124

    def _further(self) -> float:
        """Go on where the first steps did not lead to the end, with a way out for Ctrl-C."""
        given, frame = self._given, self._frame
        if OUTCOMES[given.outcome] == "step budget" and self._left:
            frame.given["t_end"].value, frame.given["max_steps"].value = given.t_end, self._left
            given.outcome = frame.function(*frame.given.values())
            given.steps += frame.flow.steps
        return float(frame.flow.t)

    @property
    def context(self) -> tuple[Any, ...]:
        """What C code that calls the flow itself is given: the runtime parameters, if any, and the struct as it is before a call."""
        given = self._frame.given
        return tuple(given[name] for name in ("p", "flow") if name in given)

    @property
    def outcome(self) -> str:
        """How the last call ended: "done", "event", "step budget" or "not finite"."""
        return OUTCOMES[self._given.outcome]

    @property
    def steps(self) -> int:
        """Steps of the last call."""
        return int(self._given.steps)

    @property
    def lost(self) -> NDArray[np.float64]:
        """What rounding took from t and from the state (1 + nq + nv,)."""
        return self._frame.lost
