"""What the emitted Taylor flow takes and gives back in Python: records that `native` makes and `motion` reads."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from phichain.contract import flows
from phichain.errors import ArrayError
from phichain.records import Held
from phichain.system.arrays import number, whole

OUTCOMES: Final = tuple(outcome.name for outcome in flows.OUTCOMES)
"""Results of NAME_propagate by their number in C."""


@dataclass(frozen=True)
class Stop:
    """A scalar whose sign change ends a propagation; one that starts at zero has not crossed.

    Attributes:
        scalar: "q" (an entry of q), "v" (an entry of v) or "depth" (how deep a link's mass hangs below the base, m).
        index: which entry, or which link, counted from 0.
        value: subtracted from the scalar.
        direction: +1 only where it rises along the way, -1 only where it falls, 0 both.
    """

    scalar: str
    index: int
    value: float = 0.0
    direction: int = 0

    def __post_init__(self) -> None:
        if not isinstance(self.scalar, str) or self.scalar not in flows.SCALARS:
            raise ArrayError(
                "stop.scalar", self.scalar, "is no scalar of the flow", 'use "q", "v" or "depth"'
            )
        index = whole("stop.index", self.index, 0, 2**31 - 1, "count entries and links from 0", ArrayError)
        direction = whole("stop.direction", self.direction, -1, 1, "use -1, 1, or 0 for both directions", ArrayError)
        value = number("stop.value", self.value, "give a finite value")
        for name, checked in (("index", index), ("direction", direction), ("value", value)):
            object.__setattr__(self, name, checked)

    @property
    def number(self) -> int:
        """The scalar's number in C."""
        return flows.SCALARS.index(self.scalar)


@dataclass(frozen=True, eq=False)
class Propagation(Held):
    """Where a propagation ended, and what it passed on the way.

    Attributes:
        outcome: "done", "event", "step budget" or "not finite".
        t: time reached, s.
        q: configuration there (nq,).
        v: rates there (nv,).
        q_at: configurations (m, nq) at the times on the way that were reached.
        v_at: rates (m, nv) there.
        tol: tolerance used, s^0: the one asked for, raised to round-off where it was below.
        order: order of the Taylor series.
        steps: steps taken.
        lost: what rounding took from t and from the state (1 + nq + nv,); the next call goes on with it.
        t_at: those times (m,), s: times that were asked for, or the ends of its own steps.
        transition: the derivatives of (q, v) that were given (nq + nv, k), carried to where it ended; None where none were.
        columns_at: the same at the times that were reached (m, nq + nv, k), where the flow carries derivatives by parameters, too.
    """

    outcome: str
    t: float
    q: NDArray[np.float64]
    v: NDArray[np.float64]
    q_at: NDArray[np.float64]
    v_at: NDArray[np.float64]
    tol: float
    order: int
    steps: int
    lost: NDArray[np.float64]
    t_at: NDArray[np.float64] = field(kw_only=True)
    transition: NDArray[np.float64] | None = field(default=None, kw_only=True)
    columns_at: NDArray[np.float64] | None = field(default=None, kw_only=True)

    @property
    def tried(self) -> int:
        """Steps tried, whether taken or not: what counts against the budget."""
        return self.steps

    def __str__(self) -> str:
        return f"{self.outcome} at t = {self.t:g} s: {self.steps} steps of order {self.order}, tolerance {self.tol:g}"


@dataclass(frozen=True, eq=False)
class StiffPropagation(Propagation):
    """The same of the implicit flow.

    Attributes:
        refused: steps tried and not taken.
        memory: size of the next step, s, and error of the last one over what was aimed at: where the next call goes on.
    """

    refused: int
    memory: tuple[float, float]

    @property
    def tried(self) -> int:
        """Steps tried, whether taken or not: what counts against the budget."""
        return self.steps + self.refused


class Carried(NamedTuple):
    """Where a propagation ended: how, the configuration, the rates and their derivatives there, and its steps."""

    outcome: str
    q: NDArray[np.float64]
    v: NDArray[np.float64]
    transition: NDArray[np.float64]
    steps: int


def carrier(flow: Any, columns: int, tol: float, max_steps: int, p: Mapping[str, Any]) -> Callable[..., Carried]:
    """(q, v, t_end, derivatives) -> where a motion is that begins there at time 0, with its derivatives.

    The flow is bound once where it can be, which spares most of what a call from Python costs.

    Args:
        flow: `propagate` of a system that carries derivatives.
        columns: How many.
        tol: Its tolerance.
        max_steps: Its budget.
        p: The parameters as `System.parameters` gives them.
    """
    if not hasattr(flow, "bind"):

        def called(q: ArrayLike, v: ArrayLike, t_end: float, transition: ArrayLike) -> Carried:
            found: Propagation = flow(q, v, 0.0, t_end, tol, max_steps=max_steps, transition=transition, **p)
            assert found.transition is not None
            return Carried(found.outcome, found.q, found.v, found.transition, found.steps)

        return called
    bound = flow.bind(tol, columns=columns, max_steps=max_steps, **p)

    def carried(q: ArrayLike, v: ArrayLike, t_end: float, transition: ArrayLike) -> Carried:
        bound.q[:], bound.v[:], bound.transition[:] = q, v, transition
        bound(0.0, t_end)
        q_end, v_end, moved = (np.array(part, dtype=float) for part in (bound.q, bound.v, bound.transition))
        return Carried(bound.outcome, q_end, v_end, moved, bound.steps)

    return carried
