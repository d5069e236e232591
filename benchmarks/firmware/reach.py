"""The Taylor flow in single precision on ordinary motions: how many it refuses, and how far it ends from double precision."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

import phichain
from benchmarks.firmware.scenes import chain

RUNS: Final = 200
TOLERANCES: Final = (1e-3, 1e-4, 1e-5, 1e-6)
LINKS: Final = (1, 2, 3, 4, 6, 8, 10, 13, 16)
#: By how much a start is moved to see how motions part.
_NUDGE: Final = 1e-9


@dataclass(frozen=True)
class Reach:
    """What became of the runs of one chain at one tolerance.

    Attributes:
        refused: runs that did not reach their end.
        worst: the largest error of an end, over the tolerance times how much the motion makes of a disturbance.
        workspace: bytes of the caller's.
    """

    links: int
    tolerance: float
    runs: int
    refused: int
    worst: float
    workspace: int


def refusals(links: Sequence[int] = LINKS, tolerances: Sequence[float] = TOLERANCES, runs: int = RUNS) -> Iterator[Reach]:
    """Every chain at every tolerance."""
    for count in links:
        single, double = (_flow(count, real) for real in ("float", "double"))
        starts = _starts(count, runs)
        ends = [double.propagate(q, v, 0.0, 1.0, 1e-12) for q, v in starts]
        moved = [double.propagate(q + _NUDGE, v, 0.0, 1.0, 1e-12) for q, v in starts]
        growth = [max(1.0, _apart(one, other) / _NUDGE) for one, other in zip(ends, moved, strict=True)]
        for tolerance in tolerances:
            found = [single.propagate(q, v, 0.0, 1.0, tolerance) for q, v in starts]
            ratios = [
                _apart(one, end) / (tolerance * grown) for one, end, grown in zip(found, ends, growth, strict=True) if one.outcome == "done"
            ]
            yield Reach(count, tolerance, runs, runs - len(ratios), max(ratios, default=0.0), _workspace(count))


def _flow(links: int, real: str) -> Any:
    return phichain.build(chain(f"reach{links}_{real}", links, ("propagate",), real=real, trig=None, actuated="none"), prove=False)


def _workspace(links: int) -> int:
    """Bytes of NAME_workspace in single precision, as the header says."""
    from phichain.emit.flow.propagate import flow
    from phichain.mechanics import derive

    text = flow(derive(chain(f"reach{links}_float", links, ("propagate",), trig=None, actuated="none"))).declarations
    return int(text.split(" bytes of the caller's")[0].split()[-1])


def _starts(links: int, runs: int) -> list[tuple[np.ndarray, np.ndarray]]:
    source = np.random.default_rng(13)
    return [
        (source.uniform(-np.pi, np.pi, links).astype(np.float32).astype(float), source.uniform(-0.5, 0.5, links).astype(np.float32).astype(float))
        for _ in range(runs)
    ]


def _apart(one: Any, other: Any) -> float:
    """Largest difference of two ends, rates in units of the fastest of them."""
    rates = max(1.0, float(np.max(np.abs(other.v))))
    return max(float(np.max(np.abs(one.q - other.q))), float(np.max(np.abs(one.v - other.v))) / rates)
