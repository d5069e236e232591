"""What a run by harmonics has solved on its way, so that it can be drawn, written, and gone on with."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from phichain.continuation import Branch, Evaluation, Problem, Reached
from phichain.continuation.core import REMEMBERED, Progress
from phichain.orbits.forced.checkpoint import Checkpoint, Solved
from phichain.orbits.forced.forcing import Forcing
from phichain.orbits.forced.series import Found
from phichain.orbits.harmonics.elimination import Memory, Series
from phichain.system import Parameters, System, Vector


class _Stand(NamedTuple):
    """Where the run stood at a point: what was found there, at its first point and at those it looks back on, and the memory."""

    at: bytes
    points: Mapping[bytes, Evaluation]
    memory: tuple[Series, ...]


class Record:
    """A problem that keeps what it finds: the coefficients of everything, and where the run stood at its last two points."""

    def __init__(self, problem: Problem, memory: Memory) -> None:
        """Keep what is asked of a problem, whose solutions are guessed from a memory."""
        self._evaluate, self._memory = problem.evaluate, memory
        self._seen: dict[bytes, Vector] = {}
        self._late: dict[bytes, Evaluation] = {}
        self._stands: list[_Stand] = []
        self.problem = replace(problem, evaluate=self._found)

    def _found(self, z: Vector) -> Evaluation:
        key = z.tobytes()
        known = self._late.get(key) or (self._stands[-1].points.get(key) if self._stands else None)
        if known is not None:
            return known
        found = self._evaluate(z)
        self._late[key] = found
        if isinstance(found.extra, Found):
            self._seen[key] = found.extra.series.coefficients
        return found

    def series(self, z: Vector) -> Vector:
        """The coefficients (M, n) of a point, or of an event of the branch whose checkpoint was taken."""
        return self._seen[z.tobytes()]

    def _beside(self, z: Vector, near: Vector) -> None:
        """Solve at an event, from the point before it alone: whatever the run has found since."""
        kept, coefficients = self._memory.last, self.series(near)
        free, n = (len(z) - 1) // coefficients.shape[1], coefficients.shape[1]
        still = np.zeros(((len(coefficients) - free) * n, len(z)))
        self._memory.last = [Series(near, coefficients, free, still, 0.0)]
        found: Any = self._evaluate(z)
        self._memory.last = kept
        if not isinstance(found.extra, Found):
            found = self._evaluate(z)
        self._seen[z.tobytes()] = found.extra.series.coefficients

    def take(self, z: Vector) -> None:
        """A point is the run's own from now on."""
        points = dict(self._stands[-1].points) if self._stands else {}
        points[z.tobytes()] = self._found(z)
        while len(points) > REMEMBERED + 1:
            # The first one stays: a run looks at it to see whether it has come round.
            del points[list(points)[1]]
        self._stands = [*self._stands[-1:], _Stand(z.tobytes(), points, tuple(self._memory.last))]
        self._late = {}

    def told(self, progress: Progress | None) -> Progress:
        """Takes every point, and tells it."""

        def tell(reached: Reached, step: float) -> None:
            self.take(reached.z)
            if progress is not None:
                progress(reached, step)

        return tell

    def checkpoint(self, branch: Branch) -> Checkpoint:
        """Where the run stands at the last of a branch's own points."""
        last = branch.points[branch.regular - 1]
        if last.tobytes() in self._late:
            self.take(last)
        stand = next((one for one in reversed(self._stands) if one.at == last.tobytes()), self._stands[-1])
        solved = tuple(Solved(one.extra.series, one.residual, one.jacobian) for one in stand.points.values() if isinstance(one.extra, Found))
        for event in branch.events:
            if event.z.tobytes() not in self._seen:
                self._beside(event.z, branch.points[event.index])
        made = Checkpoint(branch, solved=solved, memory=stand.memory)
        return replace(made, series=tuple(self.series(z) for z in made.places))

    def restore(self, earlier: Checkpoint, system: System, forcing: Forcing, p: Parameters | None) -> None:
        """Stand where an earlier run stood."""
        self._seen = {z.tobytes(): series for z, series in zip(earlier.places, earlier.series, strict=False)}
        points = {
            one.series.z.tobytes(): Evaluation(one.residual, one.jacobian, Found(system, forcing, one.series, p)) for one in earlier.solved
        }
        self._memory.last = list(earlier.memory)
        self._stands = [_Stand(earlier.branch.points[earlier.branch.regular - 1].tobytes(), points, earlier.memory)]
