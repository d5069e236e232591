"""phichain's own methods on a case: which there are, at which tolerance, and what they answer."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from benchmarks.stability.cases.case import Case
from benchmarks.stability.references import Reference, gap, relative_gap
from benchmarks.stability.verdict import Answer
from phichain.errors import PhichainError
from phichain.motion import METHODS, Event, Trajectory, simulate
from phichain.system import System

FIXED_STEPS = 20_000
"""Steps of a fixed-step method over the whole time; its estimate is the difference to half as many."""
ENERGY_POINTS = 401


@dataclass(frozen=True)
class Method:
    """One row of a case.

    Attributes:
        label: how the table calls it.
        name: the method of `simulate`.
        tolerance: relative; 0 for a fixed step.
        quick: whether a quick run takes it.
    """

    label: str
    name: str
    tolerance: float
    quick: bool = False


_ALL = (
    Method("auto", "auto", 1e-9, True),
    Method("auto, 1e-14", "auto", 1e-14, True),
    Method("taylor", "taylor", 2.0**-52, True),
    Method("taylor, 1e-9", "taylor", 1e-9, True),
    Method("rosenbrock, 1e-9", "rosenbrock", 1e-9, True),
    Method("rosenbrock, 1e-12", "rosenbrock", 1e-12),
    Method("DOP853, 1e-13", "DOP853", 1e-13, True),
    Method("RK45, 1e-10", "RK45", 1e-10),
    Method("Radau, 1e-10", "Radau", 1e-10, True),
    Method("BDF, 1e-8", "BDF", 1e-8),
    Method("LSODA, 1e-12", "LSODA", 1e-12),
    Method("cvodes, 1e-12", "cvodes", 1e-12, True),
    Method("cvodes_adams, 1e-12", "cvodes_adams", 1e-12),
    Method("idas, 1e-10", "idas", 1e-10),
    Method("step", "step", 0.0),
    Method("step_lie4", "step_lie4", 0.0),
    Method("step_variational", "step_variational", 0.0),
)


def methods(quick: bool) -> tuple[Method, ...]:
    """The methods this version has."""
    return tuple(method for method in _ALL if (method.quick or not quick) and _exists(method.name))


def _exists(name: str) -> bool:
    return name == "auto" or name in METHODS or name.startswith("step_")


def answer(case: Case, system: System, method: Method, known: Reference) -> Answer:
    """What the method says about a motion, an energy or a period; whatever it refuses is an answer too."""
    try:
        return {"motion": _motion, "energy": _energy, "period": _period}[case.kind](
            case, system, method, known
        )
    except PhichainError as refusal:
        return Answer("refused", said=str(refusal))
    except NotImplementedError as refusal:
        return Answer("refused", said=str(refusal))


def accelerations(case: Case, system: System, known: Reference) -> Answer:
    """Forward dynamics, compiled."""
    arguments = (case.u,) if system.nu else ()
    found = system.forward_dynamics(np.array(case.q), np.array(case.v), *map(np.array, arguments))
    return Answer("ok", errors=(relative_gap(known.rows[0], found.tolist()),))


def _motion(case: Case, system: System, method: Method, known: Reference) -> Answer:
    times = case.times if len(case.times) > 1 else (case.times[0] / 2, *case.times)

    def at(count: int) -> tuple[Trajectory, list[Any]]:
        path = _run(case, system, method, [0.0, *times], count)
        return path, [path.x[int(np.argmin(np.abs(path.t - t)))].tolist() for t in case.times]

    path, rows = at(FIXED_STEPS)
    if path.status not in ("complete", "doubtful"):
        return Answer("unfinished", said=path.reason)
    errors = tuple(gap([exact], [row], known.fastest) for exact, row in zip(known.rows, rows, strict=True))
    estimate = 0.0 if method.tolerance else gap(rows, at(FIXED_STEPS // 2)[1], known.fastest)
    return Answer(
        "ok",
        path.reason,
        errors,
        method.tolerance,
        estimate,
        same_side(case, known, rows),
        path.counts.get("steps"),
        doubted=path.status == "doubtful",
    )


def same_side(case: Case, known: Reference, rows: Sequence[Sequence[float]]) -> bool:
    """Whether the first angle is in the turn it should be in, as long as that is watched."""
    if case.side is None:
        return True
    watched = [pair for t, *pair in zip(case.times, known.rows, rows, strict=True) if t <= case.side]
    return all(_turn(float(exact[0])) == _turn(float(found[0])) for exact, found in watched)


def _turn(angle: float) -> int:
    return math.floor((angle + math.pi) / (2 * math.pi)) if math.isfinite(angle) else -(10**9)


def _energy(case: Case, system: System, method: Method, known: Reference) -> Answer:
    def at(count: int) -> tuple[Trajectory, float]:
        path = _run(case, system, method, np.linspace(0.0, case.times[-1], ENERGY_POINTS), count)
        if path.energy is None:
            raise NotImplementedError("it records no energy")
        rest = float(np.sum(system.energy(np.zeros(system.nq), np.zeros(system.nv))))
        return path, path.energy_drift / (path.energy[0] - rest)

    path, drift = at(FIXED_STEPS)
    if path.status not in ("complete", "doubtful"):
        return Answer("unfinished", said=path.reason)
    estimate = 0.0 if method.tolerance else abs(at(FIXED_STEPS // 2)[1] - drift)
    return Answer("ok", path.reason, (drift,), method.tolerance, estimate, True, path.counts.get("steps"), doubted=path.status == "doubtful")


def _period(case: Case, system: System, method: Method, known: Reference) -> Answer:
    quarter = math.pi / (2 * float(known.rows[0][0]))
    stop = Event("mid-swing", lambda t, x: x[0], terminal=True)

    def at(count: int) -> tuple[Trajectory, float]:
        path = _run(case, system, method, (0.0, 1.5 * quarter), count, events=stop)
        return path, (math.pi / (2 * path.events[0].t) if path.events else math.nan)

    path, omega = at(FIXED_STEPS)
    if path.status != "event":
        return Answer("unfinished", said=path.reason)
    estimate = 0.0 if method.tolerance else relative_gap([omega], [at(FIXED_STEPS // 2)[1]])
    errors = (relative_gap(known.rows[0], [omega]),)
    return Answer("ok", path.reason, errors, method.tolerance, estimate, True, path.counts.get("steps"))


def _run(case: Case, system: System, method: Method, times: Any, count: int, **options: Any) -> Trajectory:
    if method.tolerance:
        options["tol"] = method.tolerance
    else:
        options["h"] = case_span(case, times) / count
    u = case.u if system.nu and case.u else None
    return simulate(
        system,
        (np.array(case.q), np.array(case.v)),
        times,
        method=method.name,
        u=u,
        max_steps=2_000_000_000,
        **options,
    )


def case_span(case: Case, times: Any) -> float:
    """Length of the whole motion, s."""
    return float(times[-1]) - float(times[0])
