"""simulate: one interface to every integrator."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from phichain.errors import ArrayError, ConvergenceError, UnsupportedError
from phichain.motion import choose
from phichain.motion.balance import opened
from phichain.motion.doubts import doubts
from phichain.motion.error import NONE, Estimate, estimated
from phichain.motion.events import Event, Scalar, as_events, marked
from phichain.motion.inputs import Table, as_input
from phichain.motion.inputs.piece import Control
from phichain.motion.ledger import Ledger
from phichain.motion.manifold import project_state, violations
from phichain.motion.methods.registry import METHODS, ROUND_OFF, USUAL, Method, method_of, named
from phichain.motion.path import Path, collect
from phichain.motion.problem import (
    Problem,
    Progress,
    bound,
    check_state,
    check_times,
    check_tolerance,
)
from phichain.motion.trajectory import Trajectory, between
from phichain.system import Parameters, System, Vector, acceleration, given_system
from phichain.system.arrays import whole
from phichain.system.drawn import looks

MOST_STEPS = 2**63 - 1
Energies = tuple[Vector, Vector] | None
_LASTED = ("complete", "event", "step budget")
SINGLE_FLOOR = 2e-6
"""A right-hand side in single precision is noise below this: error control would shrink steps for nothing."""


def simulate(
    system: System,
    x0: ArrayLike | Sequence[ArrayLike],
    t: ArrayLike,
    method: str = "auto",
    tol: float | None = None,
    *,
    u: ArrayLike | Control | Table | Mapping[str, Any] | None = None,
    sample: float | None = None,
    delay: float = 0.0,
    limit: Any = None,
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
        u: Input: None (zero), a constant (nu,), a Table or (times, values[, "held" | "linear"]) that covers the run, a law
            u(t, x), or any of them for an input by its name, as {"force": law, "torque_2": 0.1}; an input without a name
            there is zero. A law must be a pure function of (t, x): it is asked in any order, more than once. Methods that
            hold their input (taylor, rosenbrock, CVODES) run from break to break of what is constant in between; what moves
            with t or x goes through SciPy's, with the same breaks. What it writes into x changes nothing.
        sample: Ts, s: u is asked at t_0 + k Ts alone, once each, in that order (so it may have a memory), and held.
        delay: How late a sampled u acts, s, 0 or more; u is zero, or the limit nearest to it, until the first one arrives.
        limit: Saturation: L for |u_j| <= L, or (low, high), for all inputs or by name.
        p: Runtime parameters by name.
        h: Step size of a fixed-step method (step, step_lie4, step_variational), s. An implicit step's largest residual
            stands in the reason, with a warning where its iteration was not enough.
        events: Event records or callables g(t, x), located at their sign changes.
        atol: Absolute tolerance of the local error in the units of the state; default a hundredth of the relative
            one, so that small motions keep digits.
        max_steps: Step budget; when it runs out the trajectory so far comes back with status "step budget".
        project: Put spatial outputs on the manifold (unit q, tangent omega). The violation is recorded before.
        progress: Called with (fraction done, t) about every hundredth.
        error_estimate: Whether a second run says how large errors have become (`Trajectory.error`); it asks a law
            again at its own times, but not one that samples, whose runs have none.

    Returns:
        The Trajectory, with the method taken and why. Its status is "complete", "event", "step budget" or, where the run
        cannot vouch for its side of a separatrix, or a complete run ends beyond `holds_until`, "doubtful", and the reason says more.

    Raises:
        ArrayError: Bad x0, t, u, limit or event; a law that is no function of (t, x), or gives no finite numbers.
        ToleranceError: tol, atol, h, sample or max_steps not positive, or delay negative.
        UnsupportedError: Unknown method, one this system has not the functions for, or one that cannot serve such an input.
        ConvergenceError: Finite-time blow-up, or a tolerance that cannot be kept; `trajectory` is what there is.
    """
    system = given_system(system)
    times, method = check_times(t), named(method)
    if system.is_forced:
        raise UnsupportedError(
            "system", system.name, "is forced by A cos(omega t), which simulate does not know",
            "call system.propagate(..., forcing=(amplitude, omega)), or pass the forcing as u(t) to the scene without [forcing]",
        )  # fmt: skip
    state, notes = check_state(system, x0)
    asked = (METHODS[method].usual if method in METHODS else USUAL) if tol is None else check_tolerance(tol)
    watched = as_events(events)
    given = as_input(system, u, (float(times[0]), float(times[-1])), sample, delay, limit)
    field, jacobian, control, held = bound(system, given, p, float(times[0]), state)
    problem = Problem(
        system, field, jacobian, control, held, p, state, times, asked, asked / 100, h, watched,
        _budget(max_steps), _told(progress), notes, given if given is not None and given.has_breaks else None,
    )  # fmt: skip
    if method == "auto":
        problem = problem.within(asked / choose.SAFETY, problem.atol)
        name, why = choose.choose(problem, free=tol is None)
        if name == "taylor" and tol is None:
            problem = problem.within(ROUND_OFF, problem.atol)
    else:
        name, why = method, f"{method} as asked"
    engine = method_of(system, name)
    problem, clamped = _clamp(problem, engine, name, atol)
    ledger = Ledger(account=opened(system, p, held, control is not None and system.nu > 0))
    path = _run(problem, engine, name, ledger)
    reasons = [why, *notes, *clamped, *([] if given is None else given.remarks)]
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


def _run(problem: Problem, engine: Method, name: str, ledger: Ledger) -> Path:
    if engine.path is not None and not problem.events:
        return engine.path(problem, name, ledger)
    return collect(problem, engine.segments(problem, name, ledger), ledger.account)


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
        u = _inputs(problem, ledger, t, x)
        work, loss = (None, None) if ledger.account is None else ledger.account.at(t)
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
            work=work,
            loss=loss,
            error=None if estimate.error is None else between(t, path.t, estimate.error),
            holds_until=estimate.holds_until,
            **looks(system, problem.p),
            digest=system.digest,
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


def _inputs(problem: Problem, ledger: Ledger, t: Vector, x: Vector) -> Vector | None:
    if problem.control is None:
        return None
    control = problem.control if problem.input is None or ledger.legs is None else ledger.legs.value
    return np.array([control(float(s), y) for s, y in zip(t, x, strict=True)]).reshape(len(t), -1)

