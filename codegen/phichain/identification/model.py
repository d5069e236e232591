"""The motion that parameters predict, and its columns: how it moves with every unknown."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from phichain.errors import ConvergenceError, PhichainError
from phichain.identification.measurement import Measurement
from phichain.identification.unknowns import Unknowns
from phichain.motion import Table, simulate
from phichain.system import System, Vector

FLOW: Final = 2e-15
"""Tolerance of the Taylor flow: round-off."""
STEPPED: Final = 1e-10
"""Tolerance of other methods."""
_BUDGET: Final = 200_000
"""Steps of one run; a trial that needs more has left what was measured."""


@dataclass(frozen=True)
class Model:
    """Predicted states of a chain at measured times.

    Attributes:
        system: The chain.
        data: What was measured.
        unknowns: What is sought.
        between: What inputs do between rows: "held" or "linear".
        method: Method of `simulate`; empty for the emitted Taylor flow in one call.
        at: Places of the measured columns within the state.
    """

    system: System
    data: Measurement
    unknowns: Unknowns
    between: str
    method: str
    at: tuple[int, ...]

    @property
    def tol(self) -> float:
        """Relative tolerance of a run."""
        return STEPPED if self.method not in ("", "taylor") else FLOW

    @property
    def step(self) -> float:
        """Step of the differences, in the scaled unknowns: tol^(2/5).

        A central difference errs by about tol/h from the runs and by h^2 S^2 from what bends, S the growth of small changes along
        the run; this h keeps both near 1e-8 for S up to 100 with the Taylor flow (1e-6 with other methods), relative to the column.
        """
        return float(self.tol**0.4)

    @property
    def noise(self) -> float:
        """What tol leaves of a column, relative to it."""
        return self.tol / self.step

    def predicted(self, z: Vector, rows: int) -> Vector:
        """The measured columns of the motion at the first times.

        Args:
            z: The unknowns.
            rows: How many times.

        Returns:
            (rows, c); infinite from where the motion could not be followed on.
        """
        t, x0, p = self.data.t[:rows], self.unknowns.state(z), self.unknowns.parameters(z)
        found = np.full((rows, len(x0)), np.inf)
        found[0] = x0
        if self.method:
            states = self._simulated(t, x0, p)
            found[: len(states)] = states
        else:
            nq = self.system.nq
            more = {"u": np.zeros(self.system.nu)} if self.system.nu else {}
            run = self.system.propagate(
                x0[:nq], x0[nq:], float(t[0]), float(t[-1]), self.tol, times=t[1:], max_steps=_BUDGET, p=p, **more
            )
            reached = 1 + len(run.q_at)
            found[1:reached, :nq], found[1:reached, nq:] = run.q_at, run.v_at
        return found[:, list(self.at)]

    def columns(self, z: Vector, rows: int) -> Vector:
        """Derivatives of the predicted columns with respect to the unknowns, by central differences of the emitted flow.

        d y / d z_j = (y(z + h e_j) - y(z - h e_j)) / 2 h. The emitted code has no columns for parameters.

        Returns:
            (rows, c, k).
        """
        slopes = []
        for j in range(len(z)):
            ahead, behind = z.copy(), z.copy()
            ahead[j] += self.step
            behind[j] -= self.step
            slopes.append((self.predicted(ahead, rows) - self.predicted(behind, rows)) / (ahead[j] - behind[j]))
        return np.stack(slopes, axis=-1)

    def _simulated(self, t: Vector, x0: Vector, p: dict[str, object]) -> Vector:
        try:
            run = simulate(
                self.system, x0, t, self.method, self.tol, u=inputs(self.data, self.between), p=p, max_steps=_BUDGET, error_estimate=False
            )
        except ConvergenceError:
            return x0[None]
        return run.x if len(run.t) == len(t) and run.t[-1] == t[-1] else x0[None]


def inputs(data: Measurement, between: str) -> dict[str, Table] | None:
    """The recorded inputs as tables by name; None where there are none."""
    if data.u is None or not data.inputs:
        return None
    return {name: Table(data.t, data.u[:, k], between) for k, name in enumerate(data.inputs)}


def model(system: System, data: Measurement, unknowns: Unknowns, between: str) -> Model:
    """The model of a measurement, with the method that serves it.

    The Taylor flow runs in one call where no input was recorded; otherwise `simulate` takes the method that it would take by itself
    for the starting values, and keeps it, so that two runs differ by their parameters alone.

    Raises:
        ConvergenceError: The motion cannot be followed from the starting values.
    """
    names = (*system.q_names, *system.v_names)
    at = tuple(names.index(name) for name in data.columns)
    method = ""
    if data.inputs or not system.has("propagate"):
        try:
            method = simulate(
                system, unknowns.state(unknowns.z), data.t, "auto", STEPPED, u=inputs(data, between),
                p=unknowns.parameters(unknowns.z), max_steps=_BUDGET, error_estimate=False,
            ).method  # fmt: skip
        except ConvergenceError as failure:
            raise _unreachable(failure) from failure
    made = Model(system, data, unknowns, between, method, at)
    if not np.isfinite(made.predicted(unknowns.z, len(data.t))).all():
        raise _unreachable(None)
    return made


def _unreachable(failure: PhichainError | None) -> ConvergenceError:
    value = "a motion that ends early" if failure is None else failure.problem
    return ConvergenceError("start", value, "the motion cannot be followed from the starting values", "start from likelier values")
