"""What the emitted batch flow gives back in Python."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from phichain.records import Held
from phichain.system.propagation import Propagation


@dataclass(frozen=True, eq=False)
class PropagationBatch(Held):
    """Where n propagations ended, and what they passed on the way.

    Attributes:
        outcome: "done", "event", "step budget" or "not finite", one per trajectory.
        t: times reached, s (n,).
        q: configurations there (n, nq).
        v: rates there (n, nv).
        q_at: configurations (n, m, nq) at the times; NaN at those that a trajectory did not reach.
        v_at: rates (n, m, nv) there.
        tol: tolerance used, s^0: the one asked for, raised to round-off where it was below.
        order: order of the Taylor series.
        steps: steps taken (n,).
        written: how many of the times were reached (n,).
        lost: what rounding took from t and from the state (n, 1 + nq + nv); the next call goes on with it.
        times: the times that were asked for (m,), s.
    """

    outcome: tuple[str, ...]
    t: NDArray[np.float64]
    q: NDArray[np.float64]
    v: NDArray[np.float64]
    q_at: NDArray[np.float64]
    v_at: NDArray[np.float64]
    tol: float
    order: int
    steps: NDArray[np.int64]
    written: NDArray[np.int64]
    lost: NDArray[np.float64]
    times: NDArray[np.float64]

    def __len__(self) -> int:
        return len(self.outcome)

    def __getitem__(self, k: int) -> Propagation:
        """One trajectory, as the scalar flow would give it back."""
        reached = int(self.written[k])
        return Propagation(
            self.outcome[k], float(self.t[k]), self.q[k], self.v[k], self.q_at[k, :reached], self.v_at[k, :reached],
            self.tol, self.order, int(self.steps[k]), self.lost[k], t_at=self.times[:reached],
        )  # fmt: skip

    def __str__(self) -> str:
        counts = ", ".join(f"{number} {outcome}" for outcome, number in Counter(self.outcome).items())
        return f"{counts}: {int(self.steps.sum())} steps of order {self.order}, tolerance {self.tol:g}"
