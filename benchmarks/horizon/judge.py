"""Estimated errors of chaotic runs over those they have."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from benchmarks.horizon.cases import TIMES, WANT, Array, Case, references

LOOSE = 1e-6
RUNS: tuple[tuple[str, float | None], ...] = (("taylor", None), ("taylor", 1e-9), ("taylor", LOOSE), ("rosenbrock", None), ("step", None))
PEERS: tuple[tuple[str, float | None], ...] = (
    ("DOP853", None), ("DOP853", LOOSE), ("LSODA", None), ("LSODA", LOOSE), ("RK45", None), ("Radau", LOOSE), ("BDF", LOOSE),
)  # fmt: skip
STEP = 2.0**-8
"""Step of the fixed steps, s."""
LARGE = 1.0
"""From an error of this on, of the motion, a run is as far off as can be: it says no more."""


@dataclass(frozen=True)
class Found:
    """One run beside its reference.

    Attributes:
        case, method, tol: What ran.
        times: Where the two are compared: as long as the reference holds.
        true: Errors there, measured as `Trajectory.error` is.
        estimated: What the run says.
        status: Its status at the end of 60 s.
        holds_until: s.
    """

    case: str
    method: str
    tol: float | None
    times: Array
    true: Array
    estimated: Array
    status: str
    holds_until: float

    @property
    def ratio(self) -> Array:
        """Estimated over true errors, while both are small and above the last digit of what was recorded."""
        return self.estimated[self.counts] / self.true[self.counts]

    @property
    def counts(self) -> Array:
        """Where the ratio means something: above the last digit, and before both say that the run is lost (then it is, whatever comes)."""
        lost = np.logical_or.accumulate((self.true >= LARGE) & (self.estimated >= LARGE))
        return (self.true > 1e-15) & ~lost

    @property
    def unmarked(self) -> float:
        """Largest error before the run says that it does not hold."""
        held = self.true[self.times <= self.holds_until]
        return float(np.max(held))


def run(case: Case, method: str, tol: float | None) -> Found:
    """One run of 60 s."""
    from phichain import build
    from phichain.motion import simulate

    system = build(case.scene(WANT))
    h = STEP if method == "step" else None
    run = simulate(system, case.x0, TIMES, method, tol, h=h)
    until, exact = references()[case.name]
    kept, nq = TIMES <= until, system.nq
    off = np.abs(run.x - exact)[kept]
    reach = np.max(np.abs(run.x), axis=0)
    angle, rate = min(1.0, np.max(reach[:nq])), np.max(reach[nq:])
    true = np.maximum(np.max(off[:, :nq], axis=1) / angle, np.max(off[:, nq:], axis=1) / rate)
    return Found(case.name, method, tol, TIMES[kept], true, run.error[kept], run.status, run.holds_until)


def runs(cases: tuple[Case, ...], ways: tuple[tuple[str, float | None], ...]) -> Iterator[Found]:
    """Every case in every way."""
    for case in cases:
        for method, tol in ways:
            yield run(case, method, tol)
