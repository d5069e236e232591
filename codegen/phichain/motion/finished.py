"""A run that has ended, and what is known of it: at once the states, all else when somebody reads it.

What a caller's law u(t, x) is asked for is asked before `simulate` returns; what the chain's own C computes waits until it is read.
"""

from __future__ import annotations

import math
from functools import cached_property
from types import MappingProxyType
from typing import Any, Final

import numpy as np

from phichain.motion.doubts import doubts
from phichain.motion.error import NONE, Estimate, estimated
from phichain.motion.events import marked
from phichain.motion.ledger import Ledger
from phichain.motion.manifold import project_state, violations
from phichain.motion.methods.registry import Method
from phichain.motion.path import Path
from phichain.motion.problem import Problem
from phichain.motion.trajectory import Trajectory, between
from phichain.records import frozen
from phichain.system import Vector, acceleration
from phichain.system.drawn import entry_lengths

Energies = tuple[Vector, Vector] | None
_LASTED: Final = ("complete", "event", "step budget")


class Finished:
    """One run, its record at any times, and the verdict on it, which is found once."""

    def __init__(
        self, problem: Problem, path: Path, name: str, engine: Method, ledger: Ledger, reasons: tuple[str, ...], kept: float | None,
        is_estimated: bool, project: bool,
    ) -> None:  # fmt: skip
        """Take a run.

        Args:
            problem: What was integrated.
            path: What was found.
            name: By which method.
            engine: How that runs.
            ledger: What it counted and said.
            reasons: Why this method, and what was done to the arguments.
            kept: The error that `auto` was asked for; None where a method was named or no tolerance given.
            is_estimated: Whether its errors are to be estimated.
            project: Whether spatial outputs are put on the manifold.
        """
        self.problem, self.path, self.name, self.engine, self.ledger = problem, path, name, engine, ledger
        self.reasons, self.kept, self.is_estimated, self.project = reasons, kept, is_estimated, project

    @property
    def record(self) -> Trajectory:
        """The record of the run as it ended; complete where a caller's function would have to be asked again."""
        found = self.at(self.path.t, self.path.x, False)
        return found.settle() if self.problem.is_moved else found

    def at(self, t: Vector, x: Vector, is_refined: bool) -> Trajectory:
        """The record at times t (m,), at which the states are x (m, nx)."""
        problem, path, system, engine = self.problem, self.path, self.problem.system, self.engine
        seen, dense = _Seen(self, t, x, is_refined), path.dense
        evaluations = {} if engine.fixed else {"rhs": problem.field, "jacobian": problem.jacobian}
        fields = {
            "name": system.name,
            "space": system.space,
            "t": shut(t),
            "q": shut(seen.q),
            "v": shut(seen.v),
            "method": self.name,
            "tol": math.nan if engine.fixed else problem.tol,
            "counts": MappingProxyType(self.ledger.counted(path.steps, evaluations)),
            "q_names": system.q_names,
            "v_names": system.v_names,
            "u_names": system.u_names,
            "angles": system.angles or "",
            "digest": system.digest,
            "refine": None if dense is None else lambda grid: self.at(grid, dense(grid), True),
        }
        return Trajectory.awaiting(seen, fields)

    @cached_property
    def verdict(self) -> tuple[str, str, Estimate]:
        """Status, the reason of everything, and the estimated errors."""
        problem, path, name = self.problem, self.path, self.name
        is_asked = self.is_estimated and path.status in _LASTED
        estimate = estimated(problem, path, name, self.engine, self.kept) if is_asked else NONE
        found = [*(doubts(problem, path, name, self._energy) if path.status == "complete" else ()), *estimate.reasons]
        status = "doubtful" if found and path.status == "complete" else path.status
        return status, "; ".join(filter(None, [*self.reasons, *self.ledger.remarks, *found, path.message])), estimate

    def _energy(self) -> Vector | None:
        """Total energy along the path (m,), J, or None where the system has none."""
        nq, x = self.problem.system.nq, self.path.x
        found = energies(self.problem, x[:, :nq], x[:, nq:])
        return None if found is None else found[0] + found[1]


class _Seen:
    """A run at some times, and what of it waits to be read.

    Attributes:
        computed: Fields of a Trajectory that wait, and what computes them.
    """

    computed: Final = {
        "a": "pushed", "u": "pushed", "kinetic": "energies", "potential": "energies", "work": "books", "loss": "books",
        "length_error": "strayed", "tangency_error": "strayed", "status": "judged", "reason": "judged", "error": "judged",
        "holds_until": "judged", "events": "judged", "lengths": "sizes", "p": "valued",
    }  # fmt: skip

    def __init__(self, run: Finished, t: Vector, x: Vector, is_refined: bool) -> None:
        self.run, self.t, self.x, self.is_refined = run, t, x, is_refined
        system = run.problem.system
        self.q, self.v = x[:, : system.nq], x[:, system.nq :]
        if run.project and not system.is_planar:
            self.q, self.v = project_state(system, self.q, self.v)

    def pushed(self) -> dict[str, Any]:
        """Inputs and accelerations."""
        run, u = self.run, self._inputs()
        return {"u": u, "a": acceleration(run.problem.system, self.q, self.v, u, run.problem.p)}

    def _inputs(self) -> Vector | None:
        problem, legs = self.run.problem, self.run.ledger.legs
        if problem.control is None:
            return None
        control = problem.control if problem.input is None or legs is None else legs.value
        return np.array([control(float(s), y) for s, y in zip(self.t, self.x, strict=True)]).reshape(len(self.t), -1)

    def energies(self) -> dict[str, Any]:
        """Both energies."""
        kinetic, potential = energies(self.run.problem, self.q, self.v) or (None, None)
        return {"kinetic": kinetic, "potential": potential}

    def books(self) -> dict[str, Any]:
        """Work and loss."""
        account = self.run.ledger.account
        work, loss = (None, None) if account is None else account.at(self.t)
        return {"work": work, "loss": loss}

    def strayed(self) -> dict[str, Any]:
        """How far it left the manifold, before any projection."""
        system = self.run.problem.system
        lengths, tangency = violations(system, self.x[:, : system.nq], self.x[:, system.nq :])
        return {"length_error": lengths, "tangency_error": tangency}

    def judged(self) -> dict[str, Any]:
        """The verdict."""
        path = self.run.path
        status, reason, estimate = self.run.verdict
        return {
            "status": status,
            "reason": f"{reason}; resampled by {self.run.name}'s own interpolant" if self.is_refined else reason,
            "error": None if estimate.error is None else between(self.t, path.t, estimate.error),
            "holds_until": estimate.holds_until,
            "events": marked(path.crossings, path.t, estimate.holds_until),
        }

    def sizes(self) -> dict[str, Any]:
        """Lengths of the links."""
        return {"lengths": entry_lengths(self.run.problem.system, self.run.problem.p)}

    def valued(self) -> dict[str, Any]:
        """Runtime parameters."""
        return {"p": frozen(self.run.problem.system.values(self.run.problem.p))}


def energies(problem: Problem, q: Vector, v: Vector) -> Energies:
    """Kinetic and potential energy of states (m, nq) and (m, nv), J; None where the system has no `energy`."""
    system = problem.system
    if not system.has("energy"):
        return None
    kinetic, potential = system.energy(q, v, **system.parameters(problem.p))
    return kinetic, potential


def shut(array: Vector) -> Vector:
    """A view that nobody can write to: itself, where nobody can."""
    if not array.flags.writeable:
        return array
    view = array.view()
    view.setflags(write=False)
    return view
