"""Runs as frozen records, and records as places to go on from."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from operator import attrgetter
from typing import Any

import numpy as np

from phichain.continuation.branch import Branch
from phichain.continuation.compiled.block import Columns
from phichain.continuation.met.specials import Passage, Special
from phichain.continuation.point import Point, point_at
from phichain.continuation.problem import Multipliers, Problem
from phichain.errors import ArrayError
from phichain.system import Vector


def record(
    problem: Problem,
    points: Sequence[Point],
    specials: Sequence[Special],
    passages: Sequence[Passage],
    ended: tuple[str, str],
    name: str,
    *,
    regular: int,
    step: float,
    tol: float,
) -> Branch:
    """The Branch of some points.

    Args:
        problem: What was continued.
        points: Its points.
        specials: Located events.
        passages: Avoided crossings.
        ended: Status and reason.
        name: Name of the branch.
        regular: How many of the points are the run's own.
        step: The step to try next.
        tol: Newton's tolerance.
    """
    columns = Columns(points)

    def column(name: str) -> Vector:
        return columns.of(name, attrgetter(name))

    unknowns = column("y") * problem.sizes
    return Branch(
        name=name,
        names=problem.names,
        points=unknowns,
        arclength=column("arclength"),
        tangent=column("tangent") * problem.sizes,
        residual=column("residual"),
        iterations=column("iterations"),
        scale=problem.sizes,
        energy=None if problem.energy is None else _energies(problem.energy, column("energy"), unknowns),
        multipliers=_together(columns, points),
        events=tuple(specials),
        status=ended[0],
        reason=ended[1],
        error=None if problem.error is None else columns.of("error", problem.error),
        passages=tuple(passages),
        regular=regular,
        step=step,
        tol=tol,
    )


def _energies(of: Callable[[Vector], float], known: Vector, unknowns: Vector) -> Vector:
    """The recorded scalar of all points, as far as it is not known with them."""
    if not np.isnan(known).any():
        return known
    return np.array([of(z) if math.isnan(own) else own for own, z in zip(known.tolist(), unknowns, strict=True)])


def _together(columns: Columns, points: Sequence[Point]) -> Multipliers:
    """The multipliers of all points (m, k).

    Raises:
        ArrayError: Not every point has as many.
    """
    try:
        return columns.of("multipliers", attrgetter("multipliers"))
    except ValueError:
        counts = sorted({len(point.multipliers) for point in points})
        raise ArrayError(
            "extra.multipliers", counts, "their number changes along the branch", "give as many at every point"
        ) from None


def demand_unknowns(problem: Problem, branch: Branch) -> None:
    """Refuse a record whose points are none of a problem.

    Raises:
        ArrayError: They have another number of unknowns.
    """
    count, places = problem.unknowns, [branch.points, *(event.z[None] for event in branch.events)]
    for place in places:
        if place.shape[1] != count:
            raise ArrayError(
                "branch.points", place.shape, f"have {place.shape[1]} unknowns, and there are {count} here: {', '.join(problem.names)}",
                "name a record as it was written, of this scene",
            )  # fmt: skip


def point_of(problem: Problem, branch: Branch, index: int) -> Point:
    """A point of a record as the run had it, to the last bit where the problem's sizes are powers of two."""
    y = branch.points[index] / problem.sizes
    return point_at(problem, y, branch.tangent[index] / problem.sizes, float(branch.arclength[index]), int(branch.iterations[index]))


def joined(earlier: Branch, later: Branch, shared: int) -> Branch:
    """An earlier run and what went on from it as one Branch.

    Args:
        earlier: The first.
        later: The second, whose first points are the last of the first's own.
        shared: How many these are.
    """
    kept = earlier.regular - shared
    arrays: dict[str, Any] = {}
    for name in ("points", "arclength", "tangent", "residual", "iterations", "energy", "multipliers", "error"):
        before, after = getattr(earlier, name), getattr(later, name)
        if after is not None and before is not None:
            arrays[name] = np.concatenate([before[: earlier.regular], after[shared:]])
    first = later.arclength[0]
    events = [*(event for event in earlier.events if event.index < earlier.regular - 1), *later.events]
    return replace(
        later,
        **arrays,
        events=tuple(sorted(events, key=lambda event: event.arclength)),
        passages=(*(gap for gap in earlier.passages if gap.arclength < first), *later.passages),
        regular=kept + later.regular,
    )
