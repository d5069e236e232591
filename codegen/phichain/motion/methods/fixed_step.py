"""The emitted fixed-step methods: `step` (classical Runge-Kutta), `step_lie4`, `step_variational`, any other `step_METHOD`.

An implicit step runs a fixed number of iterations and returns, after the state, the residual they left.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

import numpy as np

from phichain.errors import ToleranceError
from phichain.motion.inputs.piece import Control
from phichain.motion.ledger import Ledger
from phichain.motion.methods.legwise import legwise
from phichain.motion.path import Segment, StalledError, StateAt
from phichain.motion.problem import Problem
from phichain.system import Vector, unpack
from phichain.system.arrays import positive

CONVERGED = 1000.0
"""Residuals above this many units of round-off say that a step's iteration was not enough."""

HOPELESS = 1e-3
"""With residuals above this the result is no solution of the step's equations, nor near one."""


def segments(problem: Problem, name: str, ledger: Ledger) -> Iterator[Segment]:
    """Equal steps of size at most h between successive outputs and breaks of the input, which is held over each.

    A state inside a step (an event, say) is the method's own step of that shorter size.

    Raises:
        ToleranceError: h is missing, not finite or not positive.
        AbsentFunctionError: The system has no such step.
        StalledError: The state stopped being finite, or the step's equations were not solved.
    """
    h = check_step(problem.h)
    residuals = _Residuals(problem, name, ledger)
    yield from legwise(problem, ledger, lambda part: _steps(part, name, h, residuals))


def _steps(problem: Problem, name: str, h: float, residuals: _Residuals) -> Iterator[Segment]:
    advance = _advance(problem, name, residuals)
    x = problem.x0
    for start, stop in zip(problem.t[:-1], problem.t[1:], strict=True):
        count = max(1, math.ceil(abs(stop - start) / h * (1 - 1e-12)))
        size = (stop - start) / count
        for k in range(count):
            t0 = float(start + k * size)
            t1 = float(stop if k == count - 1 else start + (k + 1) * size)
            u = None if problem.control is None else problem.control(t0, x)
            x1 = advance(u, x, float(size))
            if not np.all(np.isfinite(x1)):
                raise StalledError(f"{name} left the finite numbers with h = {abs(size):.6g} s")
            if residuals.largest > HOPELESS:
                raise StalledError(f"the iteration of {name} does not converge with h = {abs(size):.6g} s")
            yield Segment(t0, t1, x1, _inside(advance, u, t0, x), parts=1, control=None if u is None else _holding(u))
            x = x1


def check_step(h: float | None) -> float:
    """A positive, finite step size.

    Raises:
        ToleranceError: It is missing, zero, negative or not finite.
    """
    if h is None:
        raise ToleranceError(
            "h", h, "is missing: a fixed-step method needs its step size", "give h= in seconds"
        )
    return positive("h", h, "give h= in seconds; the span gives the direction")


class _Residuals:
    """The largest residual of an implicit step so far, kept among the run's remarks."""

    def __init__(self, problem: Problem, name: str, ledger: Ledger) -> None:
        self.name, self.ledger = name, ledger
        self.bound = CONVERGED * float(np.finfo(np.float32 if problem.system.real == "float" else float).eps)
        self.largest = 0.0

    def add(self, residual: float) -> None:
        """Take note of one step's residual."""
        if self.ledger.remarks and residual <= self.largest:
            return
        self.largest = max(self.largest, residual)
        text = f"largest residual of {self.name} {self.largest:.2g}"
        if self.largest > self.bound:
            text += f", above {self.bound:.2g}: its iteration was not enough, shorten h"
        self.ledger.remarks[:] = [text]


Advance = Callable[[Vector | None, Vector, float], Vector]


def _holding(u: Vector) -> Control:
    return lambda t, x: u


def _advance(problem: Problem, name: str, residuals: _Residuals) -> Advance:
    system = problem.system
    step = system.function(name)
    parameters = system.parameters(problem.p)

    def advance(u: Vector | None, x: Vector, h: float) -> Vector:
        q, v = unpack(system, x)
        q_next, v_next, *more = step(h, q, v, *(() if u is None or system.nu == 0 else (u,)), **parameters)
        if (
            len(more) == 1
        ):  # an iteration's residual; a pair is the error estimate, which fixed steps have no use for
            residuals.add(float(more[0]))
        return np.concatenate((q_next, v_next), axis=-1)

    return advance


def _inside(advance: Advance, u: Vector | None, t0: float, x0: Vector) -> Callable[[], StateAt]:
    return lambda: lambda t: x0 if t == t0 else advance(u, x0, t - t0)
