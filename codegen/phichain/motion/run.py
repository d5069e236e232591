"""simulate: one interface to every integrator."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from phichain.errors import ArrayError, ConvergenceError, UnsupportedError
from phichain.motion import choose
from phichain.motion.doubts import doubts
from phichain.motion.error import NONE, Estimate, estimated
from phichain.motion.events import Event, Scalar, as_events, marked
from phichain.motion.ledger import Ledger
from phichain.motion.manifold import project_state, violations
from phichain.motion.methods import fixed_step, rosenbrock, scipy_methods, sundials, taylor
from phichain.motion.path import Path, Segment, collect
from phichain.motion.problem import (
    Control,
    Problem,
    Progress,
    bind,
    check_state,
    check_times,
    check_tolerance,
)
from phichain.motion.trajectory import Trajectory, between
from phichain.system import Parameters, System, Vector, acceleration
from phichain.system.arrays import whole

EPS = float(np.finfo(float).eps)
MOST_STEPS = 2**63 - 1
USUAL = 1e-9
"""The tolerance where none is given."""
Energies = tuple[Vector, Vector] | None
_LASTED = ("complete", "event", "step budget")
SINGLE_FLOOR = 2e-6
"""A right-hand side in single precision is noise below this: error control would shrink steps for nothing."""


@dataclass(frozen=True)
class Method:
    """One integrator.

    Attributes:
        segments: Its steps one by one.
        floor: The smallest tolerance its arithmetic can keep.
        summary: What it is.
        fixed: Whether its steps are of one size, with no tolerance.
        path: How it runs a whole problem in compiled code, where no event has to be watched step by step.
        usual: The tolerance it takes when none is given.
    """

    segments: Callable[[Problem, str, Ledger], Iterator[Segment]]
    floor: float
    summary: str
    fixed: bool = False
    path: Callable[[Problem, str, Ledger], Path] | None = None
    usual: float = USUAL


METHODS: dict[str, Method] = {
    "taylor": Method(
        taylor.segments, EPS, "the emitted Taylor flow, of variable order", path=taylor.path, usual=choose.ROUND_OFF
    ),
    "rosenbrock": Method(
        rosenbrock.segments,
        64 * EPS,
        "the emitted implicit flow: Rosenbrock of order 5, L-stable",
        path=rosenbrock.path,
    ),
    "DOP853": Method(scipy_methods.segments, 100 * EPS, "explicit Runge-Kutta of order 8 (SciPy)"),
    "RK45": Method(scipy_methods.segments, 100 * EPS, "explicit Runge-Kutta of order 5 (SciPy)"),
    "Radau": Method(scipy_methods.segments, 100 * EPS, "implicit Runge-Kutta of order 5, L-stable (SciPy)"),
    "BDF": Method(scipy_methods.segments, 100 * EPS, "backward differentiation, orders 1-5 (SciPy)"),
    "LSODA": Method(scipy_methods.segments, 100 * EPS, "Adams or BDF by stiffness (SciPy)"),
    "cvodes": Method(sundials.segments, 1e-13, "CVODES, BDF with Newton (SUNDIALS through CasADi)"),
    "cvodes_adams": Method(sundials.segments, 1e-13, "CVODES, Adams (SUNDIALS through CasADi)"),
    "idas": Method(sundials.segments, 1e-13, "IDAS, BDF (SUNDIALS through CasADi)"),
    "step": Method(
        fixed_step.segments, 0.0, "the emitted fixed step: classical Runge-Kutta of order 4", fixed=True
    ),
    "step_lie4": Method(
        fixed_step.segments, 0.0, "the emitted fixed step: Runge-Kutta-Munthe-Kaas of order 4", fixed=True
    ),
    "step_variational": Method(
        fixed_step.segments, 0.0, "the emitted fixed step: variational, of order 2, symplectic", fixed=True
    ),
}


def simulate(
    system: System,
    x0: ArrayLike | Sequence[ArrayLike],
    t: ArrayLike,
    method: str = "auto",
    tol: float | None = None,
    *,
    u: ArrayLike | Control | None = None,
    p: Parameters | None = None,
    h: float | None = None,
    events: Iterable[Event | Scalar] | Event | Scalar | None = None,
    atol: float | None = None,
    max_steps: int = 1_000_000,
    project: bool = False,
    progress: Progress | None = None,
    error_estimate: bool = True,
) -> Trajectory:
    """Integrate the chain's equations of motion from one state.

    Args:
        system: The chain.
        x0: Initial state (q, v): one flat vector (nq + nv,) or the pair. Spatial states within 1e-6 of the manifold
            are projected on it and the reason says so; others are refused.
        t: A final time (from 0), a span (t0, t1) for output at the method's own steps, or a grid of output times;
            s, increasing or decreasing.
        method: A key of METHODS, "auto", or the name of an emitted step (`step_...`).
        tol: Relative tolerance, 1e-9 unless given. A named method takes it for its local error per step; auto keeps
            the local error ten times below it, so that it is about the error of a short run. The Taylor flow, named
            or taken by auto, runs at round-off unless a tolerance is given: that costs about a third more, and starts
            beside a separatrix stay on their side. Values below what the method's arithmetic can keep are raised to it
            and the reason says so.
        u: Input: None (zero), a constant (nu,), or a callable u(t, x).
        p: Runtime parameters by name.
        h: Step size of a fixed-step method (step, step_lie4, step_variational), s. An implicit step's largest residual
            stands in the reason, with a warning where its iteration was not enough.
        events: Event records or callables g(t, x), located at their sign changes.
        atol: Absolute tolerance of the local error in the units of the state; default a hundredth of the relative
            one, so that small motions keep digits.
        max_steps: Step budget; when it runs out the trajectory so far comes back with status "step budget".
        project: Put spatial outputs on the manifold (unit q, tangent omega). The violation is recorded before.
        progress: Called with (fraction done, t) about every hundredth.
        error_estimate: Whether a second run says how large errors have become (`Trajectory.error`); inputs that move have none.

    Returns:
        The Trajectory, with the method taken and why. Its status is "complete", "event", "step budget" or, where the run
        cannot vouch for its side of a separatrix, or a complete run ends beyond `holds_until`, "doubtful", and the reason says more.

    Raises:
        ArrayError: Bad x0, t, u or event.
        ToleranceError: tol, atol, h or max_steps not positive.
        UnsupportedError: Unknown method, or one this system has not the functions for.
        ConvergenceError: Finite-time blow-up, or a tolerance that cannot be kept; `trajectory` is what there is.
    """
    times, method = check_times(t), _named(method)
    state, notes = check_state(system, x0)
    asked = (METHODS[method].usual if method in METHODS else USUAL) if tol is None else check_tolerance(tol)
    watched = as_events(events)
    field, jacobian, control, held = bind(system, u, p, float(times[0]), state)
    problem = Problem(
        system, field, jacobian, control, held, p, state, times, asked, asked / 100, h, watched,
        _budget(max_steps), _told(progress), notes,
    )  # fmt: skip
    if method == "auto":
        problem = problem.within(asked / choose.SAFETY, problem.atol)
        name, why = choose.choose(problem, free=tol is None)
        if name == "taylor" and tol is None:
            problem = problem.within(choose.ROUND_OFF, problem.atol)
    else:
        name, why = method, f"{method} as asked"
    engine = _method(system, name)
    problem, clamped = _clamp(problem, engine, name, atol)
    ledger = Ledger()
    path = _run(problem, engine, name, ledger)
    reasons = [why, *notes, *clamped]
    if project and not system.is_planar:
        reasons.append("outputs were projected on the manifold")
    reasons += ledger.remarks
    energies = _energies(problem, path.x[:, : system.nq], path.x[:, system.nq :])
    kept = asked if method == "auto" and tol is not None else None
    estimate = estimated(problem, path, name, engine, kept) if error_estimate and path.status in _LASTED else NONE
    found = [*(doubts(problem, path, name, energies and energies[0] + energies[1]) if path.status == "complete" else ()), *estimate.reasons]
    if found:
        path, reasons = replace(path, status="doubtful" if path.status == "complete" else path.status), [*reasons, *found]
    trajectory = _record(
        problem, path, name, engine, ledger, "; ".join(filter(None, [*reasons, path.message])), project, energies, estimate
    )
    if path.status in ("blow-up", "stalled"):
        raise ConvergenceError(
            "simulate", name, path.message, _remedy(path.status, engine), t=float(path.t[-1]), status=path.status,
            trajectory=trajectory,
        )  # fmt: skip
    return trajectory


def _budget(max_steps: int) -> int:
    return whole("max_steps", max_steps, 1, MOST_STEPS, "leave it out for a million steps")


def _told(progress: Progress | None) -> Progress | None:
    if progress is not None and not callable(progress):
        raise ArrayError("progress", progress, "cannot be called", "give a callable of (fraction done, t), or leave it out")
    return progress


def _named(method: str) -> str:
    if not isinstance(method, str):
        raise UnsupportedError("method", method, "no such method", f"use auto or one of {', '.join(METHODS)}")
    return method


def _method(system: System, name: str) -> Method:
    if name in METHODS:
        return METHODS[name]
    if name.startswith("step_"):
        system.function(name)
        return replace(METHODS["step"], summary=f"the emitted fixed step {name}")
    raise UnsupportedError("method", name, "no such method", f"use auto or one of {', '.join(METHODS)}")


def _run(problem: Problem, engine: Method, name: str, ledger: Ledger) -> Path:
    if engine.path is not None and not problem.events:
        return engine.path(problem, name, ledger)
    return collect(problem, engine.segments(problem, name, ledger))


def _clamp(problem: Problem, engine: Method, name: str, atol: float | None) -> tuple[Problem, list[str]]:
    single = problem.system.real == "float" and not engine.fixed
    tol = max(problem.tol, engine.floor, SINGLE_FLOOR if single else 0.0)
    whose = "single precision" if single else name
    said = f"tol {problem.tol:g} was raised to {tol:.2g}, the round-off floor of {whose}"
    absolute = tol / 100 if atol is None else check_tolerance(atol, "atol")
    return problem.within(tol, absolute), [said] if tol != problem.tol else []


def _remedy(status: str, engine: Method) -> str:
    if engine.fixed and status == "stalled":
        return "shorten h, or let auto choose the step; the trajectory up to there is in `.trajectory`"
    if status == "blow-up":
        return "look at the input or the parameters that drive it; the trajectory up to there is in `.trajectory`"
    return "loosen tol, or try an implicit method (rosenbrock, Radau, cvodes); the trajectory up to there is in `.trajectory`"


def _record(
    problem: Problem, path: Path, name: str, engine: Method, ledger: Ledger, reason: str, project: bool, energies: Energies,
    estimate: Estimate,
) -> Trajectory:
    system = problem.system
    dense = path.dense

    def at(t: Vector, x: Vector, energies: Energies, refined: bool) -> Trajectory:
        q, v = x[:, : system.nq], x[:, system.nq :]
        length_error, tangency_error = violations(system, q, v)
        if project and not system.is_planar:
            q, v = project_state(system, q, v)
            energies = _energies(problem, q, v)
        u = _inputs(problem, t, x)
        kinetic, potential = energies or (None, None)
        return Trajectory(
            name=system.name,
            space=system.space,
            t=t,
            q=q,
            v=v,
            a=acceleration(system, q, v, u, problem.p),
            u=u,
            kinetic=kinetic,
            potential=potential,
            length_error=length_error,
            tangency_error=tangency_error,
            events=marked(path.crossings, path.t, estimate.holds_until),
            method=name,
            status=path.status,
            reason=f"{reason}; resampled by {name}'s own interpolant" if refined else reason,
            tol=math.nan if engine.fixed else problem.tol,
            counts=ledger.counted(path.steps, {} if engine.fixed else {"rhs": problem.field, "jacobian": problem.jacobian}),
            q_names=system.q_names,
            v_names=system.v_names,
            u_names=system.u_names,
            error=None if estimate.error is None else between(t, path.t, estimate.error),
            holds_until=estimate.holds_until,
            refine=None if dense is None else lambda grid: resampled(grid, dense(grid)),
        )

    def resampled(t: Vector, x: Vector) -> Trajectory:
        return at(t, x, _energies(problem, x[:, : system.nq], x[:, system.nq :]), True)

    return at(path.t, path.x, energies, False)


def _energies(problem: Problem, q: Vector, v: Vector) -> Energies:
    """Kinetic and potential energy of states (m, nq) and (m, nv), J; None where the system has no `energy`."""
    system = problem.system
    if not system.has("energy"):
        return None
    kinetic, potential = system.energy(q, v, **system.parameters(problem.p))
    return kinetic, potential


def _inputs(problem: Problem, t: Vector, x: Vector) -> Vector | None:
    if problem.control is None:
        return None
    return np.array([problem.control(float(s), y) for s, y in zip(t, x, strict=True)]).reshape(len(t), -1)

