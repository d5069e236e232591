"""Medians, quartiles and ratios within one run: how every time in the tables is taken."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Samples = NDArray[np.float64]
LEAST = 2e-3
"""Seconds that a sample lasts at least: short calls are repeated."""
LONG = 0.3
"""Seconds from which one call is enough to know how long the next will take."""


@dataclass(frozen=True)
class Spread:
    """A median and its quartiles."""

    median: float
    low: float
    high: float

    def text(self, digits: int = 3, unit: float = 1.0) -> str:
        """``median [low, high]`` in that unit."""
        parts = [f"{value / unit:.{digits}g}" for value in (self.median, self.low, self.high)]
        return f"{parts[0]} [{parts[1]}, {parts[2]}]"


def spread(samples: Samples) -> Spread:
    """Median and quartiles of samples."""
    low, median, high = np.percentile(samples, (25, 50, 75))
    return Spread(float(median), float(low), float(high))


def ratios(samples: Samples, to: int) -> list[Spread]:
    """Every column over column `to`, round by round."""
    return [spread(samples[:, i] / samples[:, to]) for i in range(samples.shape[1])]


def race(
    runs: Sequence[Callable[[], object]],
    rounds: int,
    budget: float = 10.0,
    clock: Callable[[], float] = time.process_time,
) -> Samples:
    """Seconds per call, shape (rounds, runs): all of them in turn, round after round, in rotating order.

    Args:
        runs: What to time; each is called before, twice where it is short.
        rounds: At most so many; at least three.
        budget: Seconds for all of it, about.
        clock: Processor time of the process unless several cores are what is timed.
    """
    single = []
    for run in runs:
        seconds = _seconds(run, clock)
        # the first call of a short one fills caches; a long one tells enough at once
        single.append(max(seconds if seconds > LONG else _seconds(run, clock), 1e-7))
    repeats = [max(1, int(np.ceil(LEAST / seconds))) for seconds in single]
    a_round = sum(seconds * repeat for seconds, repeat in zip(single, repeats, strict=True))
    taken = max(3, min(rounds, int(budget / a_round)))
    samples = np.empty((taken, len(runs)))
    for turn in range(taken):
        for place in range(len(runs)):
            i = (place + turn) % len(runs)
            begin = clock()
            for _ in range(repeats[i]):
                runs[i]()
            samples[turn, i] = (clock() - begin) / repeats[i]
    return samples


def _seconds(run: Callable[[], object], clock: Callable[[], float]) -> float:
    begin = clock()
    run()
    return clock() - begin
