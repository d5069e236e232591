"""The Taylor flow in single precision on ordinary motions: how many it refuses, and how far it ends from double precision.

A tolerance is of what each step does to the motion, and the motion carries that on: with the transition matrix Phi(1, s) from time s to the
end, D the units of angles and rates (the fastest of the motion at that time, 1 rad/s at least), and W that of the end,

    growth = max_s || W Phi(1, s) D(s) ||,      condition = integral of || W |Phi(1, s)| |f(s)| || ds,      max norms

An error of one tolerance at the worst time in the worst direction ends as tolerance x growth. `condition` is the problem's own, whatever
integrates it: accelerations and rates that are wrong by half a unit in the last place, u = 2^-24, end as u x condition.
"""

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
#: Half a unit in the last place of a number in single precision, relative to it.
_ROUNDING: Final = 2.0**-24
#: What the motion that the others are measured by is computed at.
_EXACT: Final = 1e-12

Numbers = np.ndarray
Start = tuple[Numbers, Numbers]


@dataclass(frozen=True)
class Reach:
    """What became of the runs of one chain at one tolerance.

    Attributes:
        refused: runs that did not reach their end.
        typical: median error of an end.
        worst: the largest error of an end, over the tolerance times the motion's growth.
        worst_double: the same of the flow in double precision.
        of_rounding: the largest error of an end, over what rounding alone may cost by the motion's condition.
        workspace: bytes of the caller's.
    """

    links: int
    tolerance: float
    runs: int
    refused: int
    typical: float
    worst: float
    worst_double: float
    of_rounding: float
    workspace: int


@dataclass(frozen=True)
class _Motion:
    """Where a motion ends, and what it makes of errors on the way."""

    q: Numbers
    v: Numbers
    growth: float
    condition: float


def refusals(links: Sequence[int] = LINKS, tolerances: Sequence[float] = TOLERANCES, runs: int = RUNS) -> Iterator[Reach]:
    """Every chain at every tolerance."""
    for count in links:
        single, double = (_flow(count, real, ("propagate",), False) for real in ("float", "double"))
        starts = _starts(count, runs)
        judge = _flow(count, "double", ("propagate", "forward_dynamics"), True)
        motions = [_motion(judge, start) for start in starts]
        growth, condition = (np.array([getattr(one, name) for one in motions]) for name in ("growth", "condition"))
        for tolerance in tolerances:
            errors, other = (_errors(flow, starts, motions, tolerance) for flow in (single, double))
            yield Reach(
                count, tolerance, runs, int(np.sum(np.isnan(errors))), float(np.nanmedian(errors)), float(np.nanmax(errors / (tolerance * growth))),
                float(np.nanmax(other / (tolerance * growth))), float(np.nanmax(errors / (_ROUNDING * condition))), _workspace(count),
            )  # fmt: skip


def _flow(links: int, real: str, want: tuple[str, ...], is_variational: bool) -> Any:
    name = f"reach{links}_{real}{'_varied' if is_variational else ''}"
    return phichain.build(chain(name, links, want, real=real, trig=None, actuated="none", variational=is_variational), prove=False)


def _errors(flow: Any, starts: Sequence[Start], motions: Sequence[_Motion], tolerance: float) -> Numbers:
    """The errors of the ends; NaN where a run was refused."""
    ends = [flow.propagate(q, v, 0.0, 1.0, tolerance) for q, v in starts]
    return np.array([_apart(end, motion) if end.outcome == "done" else np.nan for end, motion in zip(ends, motions, strict=True)])


def _motion(system: Any, start: Start) -> _Motion:
    """The whole of it, piece by piece, with the transition matrix of each."""
    links, pieces = len(start[0]), max(20, 4 * len(start[0]))
    q, v = start
    transitions, slopes, units = [], [], []
    for _ in range(pieces):
        slopes.append(np.abs(np.concatenate([v, system.forward_dynamics(q, v)])))
        units.append(np.repeat([1.0, max(1.0, float(np.max(np.abs(v))))], links))
        end = system.propagate(q, v, 0.0, 1.0 / pieces, _EXACT, transition=np.eye(2 * links))
        q, v = end.q, end.v
        transitions.append(end.transition)
    onwards, growth, condition = np.eye(2 * links), 1.0, 0.0
    of_end = 1 / np.repeat([1.0, max(1.0, float(np.max(np.abs(v))))], links)
    for transition, slope, unit in zip(reversed(transitions), reversed(slopes), reversed(units), strict=True):
        onwards = onwards @ transition
        sizes = of_end[:, None] * np.abs(onwards)
        growth = max(growth, float(np.max(sizes @ unit)))
        condition += float(np.max(sizes @ slope)) / pieces
    return _Motion(q, v, growth, condition)


def _workspace(links: int) -> int:
    """Bytes of NAME_workspace in single precision, as the header says."""
    from phichain.emit.flow.propagate import flow
    from phichain.mechanics import derive

    text = flow(derive(chain(f"reach{links}_float", links, ("propagate",), trig=None, actuated="none"))).declarations
    return int(text.split(" bytes of the caller's")[0].split()[-1])


def _starts(links: int, runs: int) -> list[Start]:
    source = np.random.default_rng(13)
    return [
        (source.uniform(-np.pi, np.pi, links).astype(np.float32).astype(float), source.uniform(-0.5, 0.5, links).astype(np.float32).astype(float))
        for _ in range(runs)
    ]


def _apart(one: Any, other: Any) -> float:
    """Largest difference of two ends, rates in units of the fastest of them."""
    rates = max(1.0, float(np.max(np.abs(other.v))))
    return max(float(np.max(np.abs(one.q - other.q))), float(np.max(np.abs(one.v - other.v))) / rates)
