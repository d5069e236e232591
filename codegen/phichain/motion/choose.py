"""Which method `auto` takes: by stiffness and tolerance, and it says why.

A problem is called stiff when an explicit method would take steps for stability rather than for accuracy. With
eigenvalues lambda of df/dx at the start, an explicit method of order 8 needs about T max(-Re lambda) / 6 steps to
stay stable (its real stability interval; of the decay counts what exceeds the fastest growth, since a chain that keeps
its energy has every decay paired with a growth), and about T omega tol^(-1/8) / 10 steps to follow oscillations of rate
omega, the fastest of the lightly damped eigenvalues, of the motion itself and of 1/T.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from phichain.motion.methods import rosenbrock, taylor
from phichain.motion.problem import Problem, differences
from phichain.system import System, Vector, angular_velocities, pack, rhs, rhs_jacobian

SAFETY = 10.0
"""How far `auto` keeps the local error below the tolerance: errors add up over the steps."""

STABLE_INTERVAL = 6.0
WORTH_IT = 1000.0
"""Fewer stability-limited steps than this are taken explicitly: an implicit step costs more."""

UNDAMPED = "nothing damps the chain, so that whatever decays has a partner that grows as fast"


@dataclass(frozen=True)
class Stiffness:
    """How stiff a problem is at its start, or where it comes to rest.

    Attributes:
        decay: Fastest decay rate max(-Re lambda), 1/s, less the fastest growth.
        rate: Fastest rate that has to be followed, rad/s.
        stability_steps: Steps an explicit method needs to stay stable.
        accuracy_steps: Steps it needs to follow the motion.
        source: Where the eigenvalues come from.
    """

    decay: float
    rate: float
    stability_steps: float
    accuracy_steps: float
    source: str

    @property
    def is_stiff(self) -> bool:
        """True when stability would cost ten times the steps of accuracy, and more than a few."""
        return self.stability_steps > max(WORTH_IT, 10 * self.accuracy_steps)


def measure(problem: Problem) -> Stiffness:
    """Estimate the stiffness at the initial state from the eigenvalues of df/dx.

    Dry friction F tanh(v / v_0) resists a fast start by no slope at all, and F / v_0 once a rate falls below v_0: what comes to
    rest on the way is judged by the same place at rest, too, and the stiffer of both counts.

    The Jacobian is the exact one when the system has a `state_jacobian`, else forward differences.
    """
    here = _measured(problem, problem.x0, "")
    if not _rubs(problem):
        return here
    still = problem.x0.copy()
    still[problem.system.nq :] = 0.0
    rest = _measured(problem, still, " at rest")
    return rest if rest.stability_steps > here.stability_steps else here


def _rubs(problem: Problem) -> bool:
    """Whether dry friction acts, at joints or on the cart."""
    return problem.system.joints.friction is not None or problem.system.numbers.cart_friction is not None


def _measured(problem: Problem, x0: Vector, where: str) -> Stiffness:
    """The stiffness at a state."""
    t0 = float(problem.t[0])
    span = abs(float(problem.t[-1]) - t0)
    if problem.jacobian is not None:
        slope, source = problem.jacobian(t0, x0), f"exact Jacobian{where}"
    else:
        noise = float(np.finfo(np.float32 if problem.system.real == "float" else np.float64).eps)
        slope = differences(lambda x: problem.field(t0, x), x0, problem.field(t0, x0), noise)
        source = f"differenced Jacobian{where}"
    if not np.isfinite(slope).all():
        return Stiffness(float("nan"), float("nan"), 0.0, 0.0, f"{source}, not finite")
    ahead = 1.0 if problem.t[-1] > t0 else -1.0
    eigenvalues = [ahead * eigenvalue for eigenvalue in np.linalg.eigvals(slope).tolist()]
    # Every growth has its decay where energy is kept (a saddle's pair): only what decays faster is stiff.
    real = [eigenvalue.real for eigenvalue in eigenvalues]
    decay = max(0.0, -min(real) - max(0.0, *real))
    light = [abs(eigenvalue.imag) for eigenvalue in eigenvalues if abs(eigenvalue.imag) >= abs(eigenvalue.real)]
    rate = max(0.0, *light, _motion(problem), 1 / span)
    accuracy = span * rate * problem.tol ** (-1 / 8) / 10
    return Stiffness(decay, rate, span * decay / STABLE_INTERVAL, accuracy, source)


def fastest(system: System, start: Sequence[ArrayLike]) -> float:
    """The fastest rate of a chain at a start (q, v) without input, rad/s: of its eigenvalues and of the motion; NaN where it is not known."""
    x, field = pack(*start), rhs(system)
    slope = rhs_jacobian(system)(0.0, x) if system.has("state_jacobian") else differences(lambda y: field(0.0, y), x, field(0.0, x))
    if not np.isfinite(slope).all():
        return math.nan
    return float(np.max(np.abs(np.linalg.eigvals(slope))))


def _motion(problem: Problem) -> float:
    system = problem.system
    rates = problem.x0[system.nq :]
    if system.is_planar:
        return max(map(abs, rates[system.cart_size :].tolist()))
    return float(np.max(np.linalg.norm(angular_velocities(system, rates), axis=-1)))


def is_undamped(problem: Problem) -> bool:
    """Whether a scene says that nothing takes energy from the chain; of callables that stand for themselves nobody knows."""
    system = problem.system
    resists = system.joints.resists or system.numbers.brakes_cart
    return bool(system.digest) and not resists and problem.is_held


def _judged(found: Stiffness) -> tuple[bool, str]:
    if math.isnan(found.decay):
        return found.is_stiff, f"how stiff it is cannot be told ({found.source})"
    follow = f"to follow its {found.rate:.3g} rad/s takes about {max(1.0, found.accuracy_steps):.0f} explicit steps"
    if found.stability_steps < 1:
        return found.is_stiff, f"nothing in the chain decays fast enough to matter, and {follow} ({found.source})"
    limited = f"what decays fastest, by {found.decay:.3g} per second, keeps explicit methods to {found.stability_steps:.0f} steps or more"
    return found.is_stiff, f"{limited}; {follow} ({found.source})"


def choose(problem: Problem, free: bool = False) -> tuple[str, str]:
    """The method `auto` takes, and why.

    A chain without dampers under an input that is held (constant, a held table, a sampled law) loses no energy by itself:
    nothing in it decays but what grows as fast elsewhere, and no eigenvalue is asked for.

    Not stiff: the Taylor flow where the system has it and the input is held, else DOP853, or RK45 where few digits
    are asked. Stiff: the emitted implicit flow, likewise; else CVODES when the system carries a CasADi function and its
    input is held, else Radau, or BDF where few digits are asked.

    Args:
        problem: What is to be integrated.
        free: Whether no tolerance was given, so that the Taylor flow may run at round-off.
    """
    few_digits = problem.tol > 1e-4
    is_stiff, finding = (False, UNDAMPED) if is_undamped(problem) else _judged(measure(problem))
    if not is_stiff:
        method = "taylor" if taylor.is_possible(problem) else "RK45" if few_digits else "DOP853"
        at_round_off = free and method == "taylor"
        how = "at round-off, as no tolerance was given" if at_round_off else f"with local tolerance {problem.tol:g}"
        return method, f"auto took {method} {how}: not stiff, {finding}"
    if rosenbrock.is_possible(problem):
        method = "rosenbrock"
    elif problem.system.has("casadi") and problem.is_held and problem.tol >= 1e-11:
        method = "cvodes"
    else:
        method = "BDF" if few_digits else "Radau"
    return method, f"auto took {method} with local tolerance {problem.tol:g}: stiff, {finding}"
