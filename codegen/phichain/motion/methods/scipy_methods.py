"""SciPy's adaptive integrators, stepped one by one.

`solve_ivp` itself has no step budget and no progress; its solver classes have the same arithmetic, so they are
driven directly: DOP853 and RK45 (Dormand and Prince 1980; Hairer, Norsett and Wanner 1993), Radau (order 5,
Hairer and Wanner 1996), BDF (orders 1-5, Shampine and Reichelt 1997), LSODA (Petzold 1983).
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.integrate import BDF, DOP853, LSODA, RK45, OdeSolver, Radau
from scipy.linalg import LinAlgError

from phichain.motion.ledger import Ledger
from phichain.motion.methods.legwise import legwise
from phichain.motion.path import Segment, StalledError
from phichain.motion.problem import Problem

EXPLICIT: dict[str, type[OdeSolver]] = {"DOP853": DOP853, "RK45": RK45}
IMPLICIT: dict[str, type[OdeSolver]] = {"Radau": Radau, "BDF": BDF, "LSODA": LSODA}


def segments(problem: Problem, name: str, ledger: Ledger) -> Iterator[Segment]:
    """The accepted steps of one of SciPy's solvers, anew at every break of the input; errors as of `_steps`."""
    return legwise(problem, ledger, lambda part: _steps(part, name))


def _steps(problem: Problem, name: str) -> Iterator[Segment]:
    """The steps of a problem without breaks; implicit methods use the exact Jacobian when there is one.

    Raises:
        StalledError: The step size fell below the spacing of doubles, or the derivative stopped being finite.
    """
    if not np.all(np.isfinite(problem.field(float(problem.t[0]), problem.x0))):
        # SciPy's choice of a first step would be NaN, and its step loop endless.
        raise StalledError(f"{name} found a derivative that is not finite")
    solver = _solver(problem, name)
    while solver.status == "running":
        try:
            complaint = solver.step()
        except (ValueError, LinAlgError, FloatingPointError) as failure:
            # The implicit solvers factorise (I - h J): NaN in J surfaces as an exception of LAPACK's wrapper.
            raise StalledError(f"{name} met values that are not finite ({failure})") from failure
        if solver.status == "failed":
            raise StalledError(f"{name} could not keep tol {problem.tol:g}: {complaint}")
        if not np.all(np.isfinite(solver.y)):
            raise StalledError(f"{name} left the finite numbers")
        if solver.t == solver.t_old:
            # LSODA reports success with steps of length zero when it cannot go on.
            raise StalledError(f"{name} could not keep tol {problem.tol:g}: its step size fell to zero")
        yield Segment(float(solver.t_old), float(solver.t), solver.y.copy(), solver.dense_output, takes_many=True)


def _solver(problem: Problem, name: str) -> OdeSolver:
    options: dict[str, object] = {"rtol": problem.tol, "atol": problem.atol}
    kind = EXPLICIT.get(name) or IMPLICIT[name]
    if name in IMPLICIT and problem.jacobian is not None:
        options["jac"] = problem.jacobian
    return kind(problem.field, float(problem.t[0]), problem.x0, float(problem.t[-1]), **options)
