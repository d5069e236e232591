"""simulate: one interface to every integrator."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from numpy.typing import ArrayLike

from phichain.errors import ArrayError, ConvergenceError, UnsupportedError
from phichain.motion import choose
from phichain.motion.asked import check_state, check_times, check_tolerance
from phichain.motion.balance import opened
from phichain.motion.events import Event, Scalar, as_events
from phichain.motion.finished import Finished
from phichain.motion.inputs import Table, as_input
from phichain.motion.inputs.piece import Control
from phichain.motion.ledger import Ledger
from phichain.motion.methods.registry import METHODS, ROUND_OFF, USUAL, Method, method_of, named
from phichain.motion.path import Path, collect
from phichain.motion.problem import Problem, Progress, bound
from phichain.motion.trajectory import Trajectory
from phichain.records import frozen
from phichain.system import Parameters, System, given_system
from phichain.system.arrays import whole

MOST_STEPS = 2**63 - 1
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
            there is zero. A law must be a pure function of (t, x): it is asked in any order, more than once, and so is a copy of it. Methods that
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
        progress: Called with (fraction done, t) about every hundredth, and after every thousand steps where these take longer.
        error_estimate: Whether neighbours of its steps, or a second run, may say how large errors have become (`Trajectory.error`); that asks a law
            again at its own times, but not one that samples, whose runs have none.

    Returns:
        The Trajectory, with the method taken and why. Its status is "complete", "event", "step budget" or, where the run
        cannot vouch for its side of a separatrix, or a complete run ends beyond `holds_until`, "doubtful", and the reason says more.
        This verdict, where it takes a second run, is found when one of status, reason, error, holds_until or events is first read.

    Raises:
        ArrayError: Bad x0, t, u, limit or event; a law that is no function of (t, x), or gives no finite numbers.
        ToleranceError: tol, atol, h, sample or max_steps not positive, or delay negative.
        UnsupportedError: Unknown method, one this system has not the functions for, or one that cannot serve such an input.
        ConvergenceError: Finite-time blow-up, or a tolerance that cannot be kept; `trajectory` is what there is.
    """
    system = given_system(system)
    times, method, p = check_times(t), named(method), frozen(p)
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
    fields = {
        "system": system, "field": field, "jacobian": jacobian, "control": control, "held": held, "p": p, "x0": state, "t": times,
        "tol": asked, "atol": asked / 100, "h": h, "events": watched, "max_steps": _budget(max_steps), "progress": _told(progress),
        "notes": notes, "input": given if given is not None and given.has_breaks else None,
    }  # fmt: skip
    problem = Problem.made(**fields)
    if method == "auto":
        problem = problem.within(asked / choose.SAFETY, problem.atol)
        name, why = choose.choose(problem, free=tol is None)
        if name == "taylor" and tol is None:
            problem = problem.within(ROUND_OFF, problem.atol)
    else:
        name, why = method, f"{method} as asked"
    engine = method_of(system, name)
    problem, clamped = _clamp(problem, engine, name, atol)
    ledger = Ledger(account=opened(system, p, held, control is not None and system.nu > 0), is_watched=error_estimate)
    path = _run(problem, engine, name, ledger)
    reasons = (why, *notes, *clamped, *(() if given is None else given.remarks))
    if project and not system.is_planar:
        reasons = (*reasons, "outputs were projected on the manifold")
    kept = asked if method == "auto" and tol is not None else None
    trajectory = Finished(problem, path, name, engine, ledger, reasons, kept, error_estimate, project).record
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
    absolute = tol / 100 if atol is None else check_tolerance(atol, "atol")
    if tol == problem.tol:
        return (problem if absolute == problem.atol else problem.within(tol, absolute)), []
    whose = "single precision" if single else name
    return problem.within(tol, absolute), [f"tol {problem.tol:g} was raised to {tol:.2g}, the round-off floor of {whose}"]


def _remedy(status: str, engine: Method) -> str:
    if engine.fixed and status == "stalled":
        return "shorten h, or let auto choose the step; the trajectory up to there is in `.trajectory`"
    if status == "blow-up":
        return "look at the input or the parameters that drive it; the trajectory up to there is in `.trajectory`"
    return "loosen tol, or try an implicit method (rosenbrock, Radau, cvodes); the trajectory up to there is in `.trajectory`"
