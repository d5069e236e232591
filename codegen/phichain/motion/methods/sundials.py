"""CVODES and IDAS of SUNDIALS through CasADi, on the CasADi function of the forward dynamics.

The system's entry `casadi` is a casadi.Function of the forward dynamics (or a callable that makes it) with inputs
named q, v and, with actuators, u; further inputs carry runtime parameters under their names. CasADi differentiates
it, so the Newton iterations use the exact Jacobian. casadi is imported here and nowhere else in `motion`.

Reference: Hindmarsh et al., SUNDIALS, ACM TOMS 31 (2005).
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from phichain.errors import UnsupportedError
from phichain.motion.ledger import Ledger
from phichain.motion.methods.legwise import legwise
from phichain.motion.path import BudgetError, Segment, StalledError, StateAt, StatesAt
from phichain.motion.problem import Problem
from phichain.system import System, Vector

OPTIONS: dict[str, tuple[str, dict[str, Any]]] = {
    "cvodes": ("cvodes", {"linear_multistep_method": "bdf"}),
    "cvodes_adams": ("cvodes", {"linear_multistep_method": "adams"}),
    "idas": ("idas", {}),
}
POINTS = 200
"""Output intervals when none are asked for: SUNDIALS' own steps do not come out of CasADi."""


def segments(problem: Problem, name: str, ledger: Ledger) -> Iterator[Segment]:
    """One segment per output interval, anew at every break of the input; errors as of `_steps`."""
    if not problem.is_held:
        raise UnsupportedError(
            "u",
            problem.control,
            f"{name} integrates a CasADi graph and cannot call a Python control law",
            "use method='DOP853' or 'Radau', a held table, or sample=Ts for a law that samples",
        )
    span = abs(float(problem.t[-1] - problem.t[0]))
    yield from legwise(problem, ledger, lambda part: _steps(part, name, ledger, span if problem.own_steps else None))


def _steps(problem: Problem, name: str, ledger: Ledger, span: float | None) -> Iterator[Segment]:
    """The segments of a leg.

    The whole grid is integrated at once, so the multistep history is kept across outputs. When that fails, the
    intervals are walked one by one to bring back what there is before the failure.

    Args:
        problem: The leg.
        name: The method.
        ledger: Where calls are counted.
        span: How long the whole run takes, where no outputs were asked for.

    Raises:
        UnsupportedError: The system has no CasADi function, or casadi is not installed.
        BudgetError: An output interval takes more than `max_steps` steps.
        StalledError: SUNDIALS gave up.
    """
    times = problem.t
    if span is not None:
        share = abs(float(times[-1] - times[0])) / span
        times = np.linspace(times[0], times[-1], max(1, math.ceil(POINTS * share)) + 1)
    flow = _flow(problem, name, ledger)
    try:
        states = flow.along(problem.x0, times)
    except RuntimeError:
        yield from _walk(problem, flow, times)
        return
    x = problem.x0
    for start, stop, after in zip(times[:-1], times[1:], states, strict=True):
        yield _segment(problem, flow, float(start), float(stop), x, after)
        x = after


def _walk(problem: Problem, flow: _Flow, times: Vector) -> Iterator[Segment]:
    x = problem.x0
    for start, stop in pairwise(times):
        try:
            after = flow.along(x, np.array([start, stop]))[-1]
        except RuntimeError as failure:
            raise _explained(failure) from failure
        yield _segment(problem, flow, float(start), float(stop), x, after)
        x = after


def _explained(failure: RuntimeError) -> StalledError:
    found = re.search(r"(CV|IDA)_[A-Z_]+", str(failure))
    flag = found[0] if found else "no reason"
    return BudgetError(flag) if "TOO_MUCH_WORK" in flag else StalledError(f"SUNDIALS gave up with {flag}")


def _segment(problem: Problem, flow: _Flow, t0: float, t1: float, x0: Vector, x1: Vector) -> Segment:
    return Segment(t0, t1, x1, _inside(flow, t0, x0), looks=_looks(problem, t0, t1, x0, x1))


def _looks(problem: Problem, t0: float, t1: float, x0: Vector, x1: Vector) -> StatesAt:
    def at(times: Vector) -> Vector:
        # SUNDIALS' own interpolant does not come out of CasADi: a cubic through states and slopes at both ends.
        slopes = [problem.field.function(t, x) for t, x in ((t0, x0), (t1, x1))]
        states: Vector = CubicHermiteSpline([0.0, 1.0], [x0, x1], (t1 - t0) * np.array(slopes))((times - t0) / (t1 - t0))
        return states

    return at


def _inside(flow: _Flow, t0: float, x0: Vector) -> Callable[[], StateAt]:
    return lambda: lambda t: x0 if t == t0 else flow.along(x0, np.array([t0, t]))[-1]


class _Flow:
    """x(t_1), x(t_2), ... from x(t_0): CasADi integrators over a time scaled by the length of the span.

    It keeps the integrators that it made, one for every grid, and notes what each call took.
    """

    def __init__(
        self,
        make: Callable[[Sequence[float], Vector], Any],
        slope: Callable[[Vector], Vector] | None,
        values: Vector,
        ledger: Ledger,
    ) -> None:
        self.make, self.slope, self.values, self.ledger = make, slope, values, ledger
        self.made: dict[tuple[float, ...], Any] = {}

    def along(self, x0: Vector, times: Vector) -> Vector:
        """States at times[1:], starting from x0 at times[0]; shape (len(times) - 1, nx).

        Raises:
            RuntimeError: SUNDIALS gave up.
        """
        span = float(times[-1] - times[0])
        grid = tuple(((times[1:] - times[0]) / span).tolist())
        start = np.zeros(0) if self.slope is None else span * self.slope(x0)
        made = (*grid, *start.tolist())
        if made not in self.made:
            self.made[made] = self.make(grid, start)
        integrator = self.made[made]
        final = integrator(x0=x0, p=np.concatenate([[span], self.values]))["xf"]
        stats = integrator.stats()
        self.ledger.count(steps=int(stats["nsteps"]), rhs=int(stats["nfevals"]), jacobian=int(stats["nlinsetups"]))
        return np.asarray(final).T


def _flow(problem: Problem, name: str, ledger: Ledger) -> _Flow:
    system = problem.system
    casadi, dynamics = _dynamics(system, name)
    x, span = casadi.MX.sym("x", system.nx), casadi.MX.sym("span")
    u = casadi.MX.sym("u", system.nu)
    q, v = x[: system.nq], x[system.nq :]
    known = {"q": q, "v": v, "u": u}
    values = system.parameters(problem.p).get("p", {})
    arguments = [known[i] if i in known else _parameter(casadi, i, values) for i in dynamics.name_in()]
    ode = span * casadi.vertcat(_velocity(casadi, system, q, v), dynamics(*arguments))
    plugin, options = OPTIONS[name]
    shared = {"reltol": problem.tol, "abstol": problem.atol, "max_num_steps": problem.max_steps}
    equations = {"x": x, "p": casadi.vertcat(span, u), "ode": ode}

    def make(grid: Sequence[float], slope: Vector) -> Any:
        quiet = {"disable_internal_warnings": True, **options, **shared}
        if plugin == "idas":
            # IDAS starts from x' as well: what it would search for by itself, and miss on stiff chains, is known.
            quiet |= {"calc_ic": False, "init_xdot": slope.tolist()}
        return casadi.integrator("flow", plugin, equations, 0.0, list(grid), quiet)

    held = np.zeros(0) if problem.held is None else problem.held
    slope = (lambda x0: problem.field.function(0.0, x0)) if plugin == "idas" else None
    return _Flow(make, slope, held, ledger)


def _velocity(casadi: Any, system: System, q: Any, v: Any) -> Any:
    if system.is_planar:
        return v
    cart = system.cart_size
    spins = [casadi.cross(v[k : k + 3], q[k : k + 3]) for k in range(cart, system.nq, 3)]
    return casadi.vertcat(v[:cart], *spins)


def _parameter(casadi: Any, name: str, values: dict[str, Any]) -> Any:
    if name in values:
        return casadi.DM(np.asarray(values[name], dtype=float))
    if name == "p" and values:
        return casadi.DM(
            np.concatenate([np.ravel(np.asarray(value, dtype=float)) for value in values.values()])
        )
    raise UnsupportedError(
        "p",
        sorted(values),
        f"the CasADi function wants the runtime parameter '{name}'",
        f"give p={{'{name}': ...}}",
    )


def _dynamics(system: System, name: str) -> tuple[Any, Any]:
    if not system.has("casadi"):
        raise UnsupportedError(
            "method",
            name,
            f"system '{system.name}' carries no CasADi function of its forward dynamics",
            "build it with its CasADi module (functions['casadi']), or use method='Radau' or 'DOP853'",
        )
    try:
        import casadi
    except ImportError as failure:
        raise UnsupportedError(
            "method",
            name,
            "SUNDIALS comes with CasADi, which is not installed",
            "pip install casadi, or use method='Radau' or 'DOP853'",
        ) from failure
    given = system.function("casadi")
    return casadi, given if isinstance(given, casadi.Function) else given()
