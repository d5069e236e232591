"""Where connections are to be looked for: motions from all around a saddle, until one nearly ends as wanted."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import numpy as np

from phichain.orbits.connections.half import NEAR, joints_of, unpushed
from phichain.orbits.connections.saddle import Saddle, leaving
from phichain.system import Parameters, System, Vector

#: Outputs a second over the fastest growth rate.
_LOOKS: Final = 24
#: Directions beside every unstable one, each so many times nearer.
_DECADES, _PER_DECADE = 9, 12
#: Directions around it, evenly.
_AROUND: Final = 180
_TIGHT: Final = 40
_EPS: Final = float(np.finfo(float).eps)


def starts(system: System, origin: Saddle, goal: Vector, longest: float, p: Parameters | None) -> Iterator[tuple[Vector, float]]:
    """(a, T) near half connections: the first joint is there at T, the last one passes it between neighbours."""
    grid = np.linspace(0.0, longest, max(3, int(_LOOKS * longest * float(origin.rates[0]))))
    if system.links == 1:
        yield from ((np.array([way * NEAR]), t) for way in (1.0, -1.0) for t, _ in _zeros(system, origin, goal, np.array([way * NEAR]), grid, p))
        return
    before: list[tuple[float, float]] = []
    last = None
    for angle in _angles():
        found = _zeros(system, origin, goal, _around(angle), grid, p)
        if last is not None:
            for (t, miss), (t_after, miss_after) in zip(before, found, strict=False):
                if miss * miss_after < 0 and abs(t - t_after) < 1.0 / float(origin.rates[0]):
                    yield _closer(system, origin, goal, (last, angle), (miss, miss_after), t, grid, p)
        before, last = found, angle


def _around(angle: float) -> Vector:
    return NEAR * np.array([np.cos(angle), np.sin(angle)])


def _angles() -> list[float]:
    """Angles over a whole turn, ever denser towards the unstable directions."""
    near = 10.0 ** -np.linspace(0.5, _DECADES, _PER_DECADE * _DECADES)
    axes = np.pi / 2 * np.arange(5)
    return sorted({*np.linspace(0, 2 * np.pi, _AROUND), *(axis + way * step for axis in axes for way in (1, -1) for step in near)})


def _zeros(
    system: System, origin: Saddle, goal: Vector, start: Vector, grid: Vector, p: Parameters | None
) -> list[tuple[float, float]]:
    """When the first joint is there on the way, and how far the last one is off then."""
    nq, x = system.nq, leaving(system, origin, start, p)
    way = system.propagate(x[:nq], x[nq:], 0.0, float(grid[-1]), 1e-12, times=grid, **unpushed(system), **system.parameters(p))
    miss = joints_of(system, way.q_at) - goal
    first, last = miss[:, 0], miss[:, -1]
    at = np.flatnonzero(first[:-1] * first[1:] < 0)
    share = first[at] / (first[at] - first[at + 1])
    return list(zip(grid[at] + share * (grid[at + 1] - grid[at]), last[at] + share * (last[at + 1] - last[at]), strict=True))


def _closer(
    system: System, origin: Saddle, goal: Vector, between: tuple[float, float], misses: tuple[float, float], t: float, grid: Vector,
    p: Parameters | None,
) -> tuple[Vector, float]:
    """Bisect between two directions while the same zero is there."""
    (low, high), (below, _) = between, misses
    for _ in range(_TIGHT):
        middle = (low + high) / 2
        found = [(s, miss) for s, miss in _zeros(system, origin, goal, _around(middle), grid, p) if abs(s - t) < 1.0 / float(origin.rates[0])]
        if not found or high - low < _EPS:
            break
        t, miss = min(found, key=lambda entry: abs(entry[0] - t))
        if miss * below > 0:
            low, below = middle, miss
        else:
            high = middle
    return _around((low + high) / 2), t
