"""A second run to hold a first one against, at the same times: by the Taylor flow, or by the method itself.

The Taylor flow does it at a fraction of the local error. Where a system has none, or a stiff motion asks it for more steps than it
is worth, or an input moves, the method runs again: at a tenth of the tolerance, or, where its arithmetic cannot keep that or an implicit run is to stay
cheap, at ten times the tolerance, and its error is then taken for about that many times the first one's.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from typing import Final, Protocol

import numpy as np

from phichain.errors import PhichainError
from phichain.motion import choose
from phichain.motion.error.measure import LOST, Measure
from phichain.motion.ledger import Ledger
from phichain.motion.path import Path, Segment, collect
from phichain.motion.problem import Counted, Problem
from phichain.records import Held
from phichain.system import Vector, pack

#: Share of a method's local tolerance that the Taylor flow is run at; of its own.
FINER: Final = {"other": 1e-4, "taylor": 1 / 16}
#: Times or parts of the tolerance at which a method runs again.
TENFOLD: Final = 10.0
#: What the difference to a run at ten times the tolerance is taken for: order 5 makes of it 6 to 10 times the error, noise no more.
OF_LOOSER: Final = 0.3
#: Steps of the Taylor flow that a step of the other run is worth, and some for the start.
WORTH: Final = {"taylor": (2, 64), "rosenbrock": (1, 64), "other": (10, 10_000)}
#: Methods whose second run is their own where the motion is stiff.
STIFF: Final = ("rosenbrock", "cvodes", "idas", "Radau", "BDF", "LSODA")
ROUND_OFF: Final = float(np.finfo(float).eps)
#: Two runs that are so far apart (times `LOST`) are not followed further: looked at after these parts of a run of so many steps and outputs.
PARTED: Final = 2.0
LOOKS: Final = (1 / 8, 1 / 4, 1 / 2)
MANY: Final = (1024, 8)


class Method(Protocol):
    """What has to be known of a method to run it again: its steps, a whole run in compiled code where it has one, the smallest
    tolerance its arithmetic can keep, and whether its steps are of one size."""

    @property
    def segments(self) -> Callable[[Problem, str, Ledger], Iterator[Segment]]: ...
    @property
    def path(self) -> Callable[[Problem, str, Ledger], Path] | None: ...
    @property
    def floor(self) -> float: ...
    @property
    def fixed(self) -> bool: ...


@dataclass(frozen=True, eq=False)
class Beside(Held):
    """A second run.

    Attributes:
        x: Its states at the times of the first one, as far as the two have to do with each other.
        share: What part of the difference is the first one's error.
        by: What it is.
    """

    x: Vector
    share: float
    by: str


def second_run(problem: Problem, path: Path, name: str, method: Method, measure: Measure) -> Beside | None:
    """The first of the second runs that comes to the end of the path, or so far from it that it may end; None where none does.

    Args:
        problem: What was integrated.
        path: What was found.
        name: By what.
        method: How that runs.
        measure: How large a difference is.
    """
    # A law is asked in states where it was not asked before, and what it raises there says nothing of the first run.
    failures = Exception if problem.is_moved else PhichainError
    for run in _ways(problem, path, name, method, measure):
        try:
            found = run()
        except failures:
            continue
        is_whole = len(found.x) == len(path.x) or measure(found.x[-1] - path.x[len(found.x) - 1]) > PARTED * LOST
        if is_whole and np.isfinite(found.x).all():
            return found
    return None


def _ways(problem: Problem, path: Path, name: str, method: Method, measure: Measure) -> list[Callable[[], Beside]]:
    by_taylor, again = partial(_by_taylor, problem, path, name, method.fixed, measure), partial(_again, problem, path, name, method)
    if not problem.system.has("propagate") or problem.is_moved:
        return [again]
    if name in STIFF and _is_stiff(problem):
        return [again, by_taylor]
    return [by_taylor] if name == "taylor" else [by_taylor, again]


def _is_stiff(problem: Problem) -> bool:
    return not choose.is_undamped(problem) and choose.measure(_uncounted(problem)).is_stiff


def flown(problem: Problem, t: Vector, x: Vector, tol: float, budget: int) -> Vector:
    """States of the Taylor flow at times t[1:] from x at t[0], as far as it comes; shape (at most len(t) - 1, nx)."""
    nq = problem.system.nq
    given = {} if problem.held is None else {"u": problem.held}
    found = problem.system.propagate(
        x[:nq], x[nq:], float(t[0]), float(t[-1]), tol, times=t[1:], max_steps=budget, **given, **problem.system.parameters(problem.p)
    )
    return pack(found.q_at, found.v_at)


def _by_taylor(problem: Problem, path: Path, name: str, fixed: bool, measure: Measure) -> Beside:
    each, some = WORTH.get(name, WORTH["other"])
    share = FINER.get(name, FINER["other"])
    tol = ROUND_OFF if fixed else max(share * problem.tol, ROUND_OFF)
    states, last, budget = path.x[:1], len(path.t) - 1, each * path.steps + some
    least, fewest = MANY
    looks = [int(part * last) for part in LOOKS] if path.steps >= least and last >= fewest else []
    for stop in (*looks, last):
        begin = len(states) - 1
        found = flown(problem, path.t[begin : stop + 1], states[-1], tol, budget)
        states = np.concatenate([states, found])
        if len(found) < stop - begin or np.max(measure(found - path.x[begin + 1 : stop + 1])) > PARTED * LOST:
            states = _until_parted(states, path.x, measure)
            break
    return Beside(states, 1.0, f"the Taylor flow at tolerance {tol:.2g}")


def _until_parted(states: Vector, x: Vector, measure: Measure) -> Vector:
    """States up to the first that is far from those of x."""
    far = np.flatnonzero(measure(states - x[: len(states)]) > PARTED * LOST)
    return states[: far[0] + 1] if far.size else states


def _again(problem: Problem, path: Path, name: str, method: Method) -> Beside:
    if method.fixed:
        other, share, by = replace(_uncounted(problem), h=(problem.h or 0.0) / 2), 1.0, f"{name} at half the step"
    elif problem.tol / TENFOLD >= method.floor and name != "rosenbrock":
        other, share, by = _within(problem, 1 / TENFOLD), 1.0, f"{name} at a tenth of the tolerance"
    else:
        other, share, by = _within(problem, TENFOLD), OF_LOOSER, f"{name} at ten times the tolerance"
    grid = path.t if len(path.t) > 2 else np.array([path.t[0], (path.t[0] + path.t[1]) / 2, path.t[1]])
    other = replace(other, t=grid, events=(), progress=None, max_steps=int(TENFOLD) * max(path.steps, 100))
    run = method.path or (lambda p, name, ledger: collect(p, method.segments(p, name, ledger)))
    found = run(other, name, Ledger())
    return Beside(found.x if len(path.t) > 2 else found.x[[0, -1]], share, by)


def _within(problem: Problem, factor: float) -> Problem:
    return _uncounted(problem).within(factor * problem.tol, factor * problem.atol)


def _uncounted(problem: Problem) -> Problem:
    """The same problem, whose evaluations are not those of the run that is judged."""
    jacobian = None if problem.jacobian is None else Counted(problem.jacobian.function)
    return replace(problem, field=Counted(problem.field.function), jacobian=jacobian)
