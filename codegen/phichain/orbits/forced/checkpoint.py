"""Where a frequency response stands: what a run that goes on needs besides the motions themselves, to the last bit.

Shooting knows all of a motion from its start, so that the unknowns do. What the balance of harmonics finds depends, in its rounding, on the
solutions before it: those that the next ones are guessed from are kept, and what was found at the points that a run looks back on.

    "checkpoint": {"branch": {as families write it}, "before", "events", "why", "opened", "series": [[[...]]],
                   "solved": [{"z", "coefficients", "outer", "by_z", "tail", "residual", "jacobian"}], "memory": [{the same without the last two}]}
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from phichain.continuation import Branch
from phichain.continuation.document import POSSIBLE, branch_document, branch_fields
from phichain.orbits.harmonics.elimination import Series
from phichain.reading import text_of
from phichain.records import Held
from phichain.system import Vector


@dataclass(frozen=True, eq=False)
class Solved(Held):
    """The balance at one place: the series, and the equations that are left with their Jacobian."""

    series: Series
    residual: Vector
    jacobian: Vector


@dataclass(frozen=True, eq=False)
class Checkpoint(Held):
    """Where a run stands.

    Attributes:
        branch: The run in its unknowns.
        before: How many points of the response come before the first of the branch: those by harmonics where shooting goes on.
        events: How many of its events do.
        why: Why harmonics did not go on there; empty where they do.
        opened: The event that opened the branch; empty for the response itself.
        series: Coefficients (M, n) of all points of the branch, then of its events; none of motions that are shot.
        solved: The points that a run looks back on.
        memory: Solutions that the next ones are guessed from, the oldest first.
    """

    branch: Branch
    before: int = 0
    events: int = 0
    why: str = ""
    opened: str = ""
    series: tuple[Vector, ...] = ()
    solved: tuple[Solved, ...] = ()
    memory: tuple[Series, ...] = ()

    @property
    def places(self) -> list[Vector]:
        """The unknowns that `series` belongs to."""
        return [*self.branch.points, *(event.z for event in self.branch.events)]

    def document(self) -> dict[str, Any]:
        """As JSON has it."""
        solved = [
            {**_written(one.series), "residual": one.residual.tolist(), "jacobian": one.jacobian.tolist()} for one in self.solved
        ]  # fmt: skip
        return {
            "branch": branch_document(self.branch), "before": self.before, "events": self.events, "why": self.why, "opened": self.opened,
            "series": [one.tolist() for one in self.series], "solved": solved, "memory": [_written(one) for one in self.memory],
        }  # fmt: skip


def checkpoint_of(found: Mapping[str, Any] | None, path: Path | str, points: int, events: int) -> Checkpoint | None:
    """A checkpoint from the JSON of a response with so many points and events; None in files from before there were any.

    Raises:
        OutputError: Numbers of it are none that it can hold.
        ValueError: Its parts do not fit each other.
    """
    if found is None:
        return None
    branch = POSSIBLE.demand(path, Branch(**branch_fields(found["branch"])), "checkpoint.branch.")
    series = tuple(_table(one, 2) for one in found["series"])
    solved = tuple(Solved(_read(one), _table(one["residual"], 1), _table(one["jacobian"], 2)) for one in found["solved"])
    before, before_events = int(found["before"]), int(found["events"])
    made = Checkpoint(
        branch, before, before_events, text_of(found, "why"), text_of(found, "opened"), series, solved, tuple(map(_read, found["memory"]))
    )
    size = len(branch.names)
    fits = before >= 0 and before + len(branch) == points and 0 <= before_events <= events
    fits = fits and len(series) in (0, len(made.places)) and all(one.shape[1] == series[0].shape[1] for one in series)
    fits = fits and all(one.jacobian.shape == (size - 1, size) == (len(one.residual), len(one.series.z)) for one in solved)
    if not fits or any(len(one.z) != size for one in made.memory):
        raise ValueError("its checkpoint does not fit its points")
    return made


def _written(series: Series) -> dict[str, Any]:
    return {
        "z": series.z.tolist(), "coefficients": series.coefficients.tolist(), "outer": series.outer, "by_z": series.by_z.tolist(), "tail": series.tail,
    }  # fmt: skip


def _read(found: Mapping[str, Any]) -> Series:
    z, coefficients, outer = _table(found["z"], 1), _table(found["coefficients"], 2), int(found["outer"])
    by_z = _table(found["by_z"], 2) if found["by_z"] else np.zeros((0, len(z)))
    eliminated = (len(coefficients) - outer) * coefficients.shape[1]
    if by_z.shape != (eliminated, len(z)) or len(z) != outer * coefficients.shape[1] + 1:
        raise ValueError("a series of its checkpoint does not fit its unknowns")
    return Series(z, coefficients, outer, by_z, float(found["tail"]))


def _table(values: Any, dimensions: int) -> Vector:
    array = np.array(values, dtype=float)
    if array.ndim != dimensions or not np.all(np.isfinite(array)):
        raise ValueError("its checkpoint holds an array that is none, or no numbers")
    return array
