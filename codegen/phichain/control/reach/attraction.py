"""The region of attraction of a regulator's equilibrium: the radius within which every start that was tried came home.

The radius is the least, over many directions, at which a start at rest no longer comes home. It is found without a bisection of each
direction: one that comes home from the least radius so far cannot lower it, and only those that do not are bisected, together. Then
starts are drawn evenly from the ball of that radius; how many of them fail bounds the share that does (Clopper and Pearson 1934).

The least of all directions falls with every direction that is tried. The radius from which all but two in a hundred come home does not; it is
what fewer directions, some thirty, find on average. Directions that come home beyond it, or fail within, are not looked at again.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.stats import beta

from phichain.control.reach.record import Attraction
from phichain.control.reach.starts import Flown, directions, turned
from phichain.errors import ControlError
from phichain.laws import GainTable
from phichain.records import Held
from phichain.system import System, Vector

NEAR: Final = 0.05
"""Level of the table at which a start has come home: well within the ellipsoid of its law."""

FAR: Final = 1e12
"""Level at which a start has flown off."""

FIRST: Final = 1e-3
"""Radius that is tried first."""

CHUNK: Final = 32
"""Starts of one call of the compiled loop: a fifth of a second at most, after which Ctrl-C is heard."""

CONFIDENCE: Final = 0.95

FEW: Final = 0.02
"""Share of the directions that may fail from the usual radius."""

Which = NDArray[np.bool_]

Progress = Callable[[int, int], None]
"""Told how many equilibria are done, and of how many."""


def attraction(
    system: System,
    table: GainTable,
    flown: Flown,
    *,
    count: int = 200,
    seconds: float = 15.0,
    precision: float = 0.01,
    seed: int = 0,
    progress: Progress | None = None,
) -> Attraction:
    """The regions of attraction of all equilibria of a table, on all processors.

    Args:
        system: The chain.
        table: Its laws.
        flown: The closed loop of both, from `build_closed_loop`.
        count: Directions, and starts drawn from the ball.
        seconds: Time within which a start must come home.
        precision: Relative width of the bracket of a radius.
        seed: Of the directions and starts.
        progress: Told after each equilibrium.

    Raises:
        ControlError: A number is not positive.
    """
    for name, value in (("count", count), ("seconds", seconds), ("precision", precision)):
        if not 0 < value < np.inf:
            raise ControlError(name, value, "is not positive", "give a positive number")
    rays = directions(system, int(count), seed)
    calls = max(1, round(seconds / flown.period))

    def one(which: int) -> _Found:
        return _found(_Trial(system, table, flown, which, calls), rays, precision, int(count), seed)

    found: list[_Found] = []
    pool = ThreadPoolExecutor(os.cpu_count() or 1)
    try:
        for result in pool.map(one, range(len(table.signs))):
            found.append(result)
            if progress is not None:
                progress(len(found), len(table.signs))
    finally:
        pool.shutdown(cancel_futures=True)
    failed = np.array([one.failed for one in found])
    return Attraction(
        name=table.name, digest=table.digest, p=table.p, s=np.array(table.signs), radius=np.array([one.radius for one in found]),
        beyond=np.array([one.beyond for one in found]), usual=np.array([one.usual for one in found]), worst=np.array([one.worst for one in found]), late=np.array([int(one.late) for one in found]),
        directions=len(rays),
        tested=int(count), failed=failed, share=_upper(failed, int(count)), runs=np.array([one.runs for one in found]),
        seconds=float(seconds), period=float(flown.period), seed=seed,
    )  # fmt: skip


def _upper(failed: Vector, tested: int) -> Vector:
    """Upper end of the one-sided interval of the share that fails (count,)."""
    return np.asarray(np.where(failed >= tested, 1.0, beta.ppf(CONFIDENCE, failed + 1, np.maximum(tested - failed, 1))))


@dataclass(frozen=True, eq=False)
class _Found(Held):
    radius: float
    beyond: float
    usual: float
    worst: Vector
    late: bool
    failed: int
    runs: int


class _Trial:
    """Starts of one equilibrium, counted as they are run."""

    def __init__(self, system: System, table: GainTable, flown: Flown, which: int, calls: int) -> None:
        self.system, self.flown, self.which, self.calls = system, flown, which, calls
        self.s, self.runs = table.signs[which], 0

    def home(self, xi: Vector) -> Which:
        """Which of the starts come home (count,)."""
        return np.asarray(self.verdicts(xi) == 1)

    def verdicts(self, xi: Vector) -> Vector:
        """1 for home, 0 for flown off, -1 for still under way (count,)."""
        verdicts = []
        for start in range(0, len(xi), CHUNK):
            states = turned(self.system, self.s, xi[start : start + CHUNK])
            verdicts.append(self.flown(self.which, states, self.calls, NEAR, FAR)[0])
        self.runs += len(xi)
        return np.concatenate(verdicts)


def _found(trial: _Trial, rays: Vector, precision: float, count: int, seed: int) -> _Found:
    home, beyond, worst = 0.0, np.inf, rays[0]
    for start in range(0, len(rays), CHUNK):
        chunk = rays[start : start + CHUNK]
        home, beyond, worst = _lowered(trial, chunk, (home, beyond, worst), precision)
    draw = np.random.default_rng([seed, trial.which])
    parts = draw.normal(size=(count, rays.shape[1]))
    parts *= (draw.uniform(size=count) ** (1 / rays.shape[1]) / np.linalg.norm(parts, axis=1))[:, None]
    failed = count - int(np.sum(trial.home(home * parts)))
    late = bool(np.isfinite(beyond) and trial.verdicts(beyond * worst[None])[0] == -1)
    return _Found(home, beyond, _usual(trial, rays, (home, beyond), precision), worst, late, failed, trial.runs)


def _lowered(trial: _Trial, rays: Vector, before: tuple[float, float, Vector], precision: float) -> tuple[float, float, Vector]:
    """The largest radius from which all rays so far come home, the least from which one does not, and that one."""
    home, beyond, worst = before
    if beyond == np.inf:
        home, beyond, left = _first(trial, rays)
        if beyond == np.inf:
            return home, beyond, worst
    else:
        left = rays[~trial.home(home * rays)]
        if not len(left):
            return before
        beyond, home = home, home / 2
        while not np.all(came := trial.home(home * left)):
            left, beyond, home = left[~came], home, home / 2
            if home < np.finfo(float).tiny:
                return 0.0, beyond, left[0]
    worst = left[0]
    while beyond - home > precision * beyond:
        middle = (home + beyond) / 2
        came = trial.home(middle * left)
        if np.all(came):
            home = middle
        else:
            left, beyond = left[~came], middle
            worst = left[0]
    return home, beyond, worst


def _usual(trial: _Trial, rays: Vector, least: tuple[float, float], precision: float) -> float:
    """The radius from which all but a few of the rays come home; that from which all do where they are few themselves."""
    few = round(FEW * len(rays))
    home, beyond = least
    if beyond == np.inf or few < 1 or home == 0:
        return home
    fallen, left = 0, rays
    # Outwards until more than a few fail; rays that do are settled.
    while True:
        came = trial.home(beyond * left)
        if fallen + int(np.sum(~came)) > few:
            left = left[~came]
            break
        fallen, left, home, beyond = fallen + int(np.sum(~came)), left[came], beyond, 1.25 * beyond
        if beyond > 2 * np.pi:
            return home
    while beyond - home > precision * beyond:
        middle = (home + beyond) / 2
        came = trial.home(middle * left)
        if fallen + int(np.sum(~came)) > few:
            left, beyond = left[~came], middle
        else:
            fallen, left, home = fallen + int(np.sum(~came)), left[came], middle
    return home


def _first(trial: _Trial, rays: Vector) -> tuple[float, float, Vector]:
    """A radius from which all come home, one from which some do not, and those; infinite where all come home from wherever rays lead."""
    radius, home = FIRST, 0.0
    while radius < np.pi:
        came = trial.home(radius * rays)
        if not np.all(came):
            left = rays[~came]
            if home:
                return home, radius, left
            while not np.all(came := trial.home(radius / 2 * left)):
                left, radius = left[~came], radius / 2
                if radius < np.finfo(float).tiny:
                    break
            return radius / 2, radius, left
        home, radius = radius, 2 * radius
    came = trial.home(np.pi * rays)
    return (np.pi, np.inf, rays) if np.all(came) else (home, np.pi, rays[~came])
