"""The integrators that `simulate` knows, by name: how each runs, how exactly it can, and what it is."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from phichain.errors import UnsupportedError
from phichain.motion.ledger import Ledger
from phichain.motion.methods import fixed_step, rosenbrock, scipy_methods, sundials, taylor
from phichain.motion.path import Path, Segment
from phichain.motion.problem import Problem
from phichain.system import System

ROUND_OFF = float(np.finfo(float).eps)
"""Tolerance of a method run as exactly as double precision allows."""
USUAL = 1e-9
"""The tolerance where none is given."""


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
        taylor.segments, ROUND_OFF, "the emitted Taylor flow, of variable order", path=taylor.path, usual=ROUND_OFF
    ),
    "rosenbrock": Method(
        rosenbrock.segments,
        64 * ROUND_OFF,
        "the emitted implicit flow: Rosenbrock of order 5, L-stable",
        path=rosenbrock.path,
    ),
    "DOP853": Method(scipy_methods.segments, 100 * ROUND_OFF, "explicit Runge-Kutta of order 8 (SciPy)"),
    "RK45": Method(scipy_methods.segments, 100 * ROUND_OFF, "explicit Runge-Kutta of order 5 (SciPy)"),
    "Radau": Method(scipy_methods.segments, 100 * ROUND_OFF, "implicit Runge-Kutta of order 5, L-stable (SciPy)"),
    "BDF": Method(scipy_methods.segments, 100 * ROUND_OFF, "backward differentiation, orders 1-5 (SciPy)"),
    "LSODA": Method(scipy_methods.segments, 100 * ROUND_OFF, "Adams or BDF by stiffness (SciPy)"),
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


def named(method: str) -> str:
    """A method's name.

    Raises:
        UnsupportedError: It is no text.
    """
    if not isinstance(method, str):
        raise UnsupportedError("method", method, "no such method", f"use auto or one of {', '.join(METHODS)}")
    return method


def method_of(system: System, name: str) -> Method:
    """The method of that name; any emitted step by its function's.

    Raises:
        UnsupportedError: There is none.
        AbsentFunctionError: The system has no such step.
    """
    if name in METHODS:
        return METHODS[name]
    if name.startswith("step_") and name != "step_jacobian":
        system.function(name)
        return replace(METHODS["step"], summary=f"the emitted fixed step {name}")
    raise UnsupportedError("method", name, "no such method", f"use auto or one of {', '.join(METHODS)}")
