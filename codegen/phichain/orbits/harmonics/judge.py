"""Shooting beside the balance of harmonics: the same orbits by another route, to check points and to go on where series get too long."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Final

import numpy as np

from phichain.continuation import Branch, Engine, Evaluation, Point, Problem, TestFunction, follow, start_on
from phichain.continuation.core import Progress
from phichain.continuation.met import gaps
from phichain.continuation.problem import LateExtra, Multipliers
from phichain.errors import ConvergenceError
from phichain.orbits.harmonics.elimination import Series
from phichain.orbits.quarter import quarter_problem
from phichain.records import Held
from phichain.system import Parameters, System, Vector

RESONANT: Final = 0.3
"""Size of the harmonics above the first, in the first, from which they are no small corrections: such points are checked."""
AGREED: Final = 1e-9
"""Distance to the orbit that shooting finds, in scaled unknowns, up to which the two agree."""
SINGULAR: Final = 1e-2
"""Smallest singular value of [J; t], in units of omega^2, beside branch points and gaps: such points are checked, too."""


class Judged(LateExtra):
    """A series with the multipliers of the orbit that it is, shot over a quarter period when they are asked for."""

    def __init__(self, make: Callable[[], Multipliers], series: Series | None) -> None:
        """Keep what makes the multipliers, and the series."""
        super().__init__(lambda: (make(), None))
        self.__dict__["_series"] = series

    @property
    def found(self) -> Any:
        """The series."""
        return self.__dict__["_series"]


@dataclass(frozen=True, eq=False)
class Judge(Held):
    """Brake orbits of one mode by shooting over a quarter period.

    Attributes:
        system: A chain that shooting serves.
        p: Runtime parameters.
        omega: Frequency of the linear mode, rad/s.
        shape: Its shape (nq,).
    """

    system: System
    p: Parameters | None
    omega: float
    shape: Vector

    @cached_property
    def problem(self) -> Problem:
        """The quarter period's problem."""
        return quarter_problem(self.system, self.p, omega=self.omega, shape=self.shape)

    def judged(self, balance: Problem) -> Problem:
        """The balance's problem with errors and multipliers that shooting knows."""

        def evaluate(z: Vector) -> Evaluation:
            residual, jacobian, extra = balance.evaluate(z)
            return Evaluation(residual, jacobian, Judged(lambda: self.kappa(z), extra.found))

        return replace(balance, evaluate=evaluate, error=self.error)

    def kappa(self, z: Vector) -> Multipliers:
        """(mu + 1/mu) / 2 (N - 1,) of the orbit from (q_0, omega); NaN where the chain cannot be followed from there."""
        found = self.problem.evaluate(z).extra.multipliers
        count = self.system.links - 1
        return found if len(found) == count else np.full(count, np.nan, complex)

    def distance(self, y: Vector, tangent: Vector) -> float:
        """How far a point is from the orbit beside it, across its branch, in scaled unknowns: Newton's first correction."""
        residual, jacobian, _ = self.problem.at(y)
        bordered = np.vstack([jacobian, tangent])
        try:
            return float(np.linalg.norm(np.linalg.solve(bordered, np.append(residual, 0.0))))
        except np.linalg.LinAlgError:
            return float("inf")

    def error(self, point: Point) -> float:
        """The tail of a point's series, or its distance to the orbit that shooting finds where that is more and the point is near a resonance."""
        series: Series = point.extra.found
        if not (series.overtones > RESONANT or gaps.smallest(self.problem, point) < SINGULAR):
            return series.tail
        apart = self.distance(point.y, point.tangent)
        return max(series.tail, apart) if np.isfinite(apart) else 1.0

    def goes_on(
        self, branch: Branch, why: str, engine: Engine, tests: Sequence[TestFunction], name: str, through: float,
        progress: Progress | None,
    ) -> Branch:  # fmt: skip
        """The branch gone on with by shooting from the last of its own points.

        Args:
            branch: What harmonics found.
            why: Why they do not go on.
            engine: Predictor, corrector and options.
            tests: Events to locate.
            name: Of the branch.
            through: Half width of gaps that are crossed.
            progress: Told every new point.
        """
        kept = cut(branch, branch.regular)
        place = f"from s = {kept.arclength[-1]:.6g} on orbits are shot"
        try:
            start = start_on(self.problem, kept.points[-1], kept.tangent[-1], engine)
        except ConvergenceError as failure:
            return replace(kept, status="step", reason=f"{why}, and shooting does not start there: {failure.problem}")
        engine = replace(engine, options=replace(engine.options, step=min(max(kept.step, engine.options.step_min), engine.options.step_max)))
        later = follow(self.problem, start, engine, tests, name, through=through, progress=progress)
        return _behind(kept, later, f"{later.reason}; {why}: {place}")


def cut(branch: Branch, count: int) -> Branch:
    """The first points of a branch, with what lies between them."""
    arrays: dict[str, Any] = {
        name: values[:count] for name in ("points", "arclength", "tangent", "residual", "iterations", "energy", "multipliers", "error")
        if (values := getattr(branch, name)) is not None
    }  # fmt: skip
    end = branch.arclength[count - 1]
    events = tuple(event for event in branch.events if event.index < count - 1)
    return replace(branch, **arrays, events=events, passages=tuple(gap for gap in branch.passages if gap.arclength < end), regular=count)


def _behind(first: Branch, later: Branch, reason: str) -> Branch:
    """Two runs as one branch; the later one starts where the first ends."""
    s, shift = float(first.arclength[-1]), len(first) - 1
    arrays: dict[str, Any] = {
        name: np.concatenate([getattr(first, name), getattr(later, name)[1:]])
        for name in ("points", "tangent", "residual", "iterations", "multipliers")
    } | {"arclength": np.concatenate([first.arclength, later.arclength[1:] + s])}
    energy = None if first.energy is None or later.energy is None else np.concatenate([first.energy, later.energy[1:]])
    error = None if first.error is None or later.error is None else np.concatenate([first.error, later.error[1:]])
    events = tuple(replace(event, index=event.index + shift, arclength=event.arclength + s) for event in later.events)
    passages = tuple(replace(gap, arclength=gap.arclength + s) for gap in later.passages)
    return replace(
        first, **arrays, energy=energy, error=error, events=(*first.events, *events), passages=(*first.passages, *passages),
        status=later.status, reason=reason, regular=shift + later.regular, step=later.step,
    )  # fmt: skip
