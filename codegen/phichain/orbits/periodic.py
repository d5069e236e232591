"""Orbits that need not stand still, by shooting: over half a period where theta(t + T/2) = -theta(t), else
over a whole one.

With x = (q, v), the flow phi_t and s = -1 over T/2 or s = 1 over T the unknowns (x_0, eps, omega) fulfil

    phi_(T/2 or T)(x_0) - s x_0 + eps w(x_0) = 0,   dV(q_0) . v_0 = 0,   w = (0, v_0).

The energy is conserved, so that one of the closing equations follows from the others; eps unfolds it (a
damper would: dH . w is twice the kinetic energy, not zero where the chain moves) and vanishes on every orbit.
The last equation chooses the phase: the potential energy is at its least on the way (or x_0 stays in the
plane across the motion at a reference, f(x_r) . (x_0 - x_r) = 0). What is left is a curve of orbits.

A cart comes back to its mirror image after half a period only without momentum. Over a whole one its place is
free and its momentum kept: its closing equation x(T) = x_0 allows no momentum, and the one of its rate, which
follows, gives way to x_0 = 0.

Source: F. Munoz-Almaraz et al., Continuation of periodic orbits in conservative and Hamiltonian systems,
Physica D 181 (2003) 1-38.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from phichain.continuation import Evaluation, Problem
from phichain.continuation.problem import LateExtra, Multipliers
from phichain.errors import UnsupportedError
from phichain.orbits.closed.canonical import across, frame, pairs
from phichain.orbits.closed.states import energy_of, field, gradient
from phichain.orbits.quarter import EPS, frequency_error, powers
from phichain.records import Held
from phichain.system import Parameters, System, Vector, acceleration
from phichain.system.propagation import carrier

_STEPS = 40_000
"""Steps of a period that are worth taking."""
_BESIDE = 1e-3
"""Turn, rad, over which the potential's slope is differenced, to the fourth order: 1e-13 of it is lost."""
Phase = Callable[[Vector], tuple[float, Vector]]
"""x_0 (2 nq,) -> a number that vanishes at the phase where orbits are taken up, and its derivative (2
nq,)."""


@dataclass(frozen=True, eq=False)
class PeriodMap(Held):
    """The variational equations over what closes the orbit.

    Attributes:
        symplectic: They (2 N - 2, 2 N - 2), times s, in canonical coordinates across the flow and the
            energy's gradient.
        slope: The energy's derivative by the state (2 nq,), J.
        turning: How the phase passes: its rate of change along the motion, in its own size; 0 where it is
            lost.
        end: (q, v) where it closes (2 nq,).
        noise: What rounding may have left in the residual (2 nq + 1,).
    """

    symplectic: Vector
    slope: Vector
    turning: float
    end: Vector
    noise: Vector


def half_problem(system: System, p: Parameters | None = None, *, omega: float, near: Vector | None = None) -> Problem:
    """Orbits with theta(t + T/2) = -theta(t), with kappa = (mu + 1/mu) / 2 of P = -M(T/2), lambda = mu^2.

    Args:
        system: A planar, undamped chain whose `propagate` carries derivatives along, with `mass_matrix` and
            `forward_dynamics`.
        p: Runtime parameters.
        omega: A frequency of the family, rad/s: its size.
        near: A state x_r = (q, v) beside which the first orbit passes, the chain moving there (2 nq,): orbits
            are taken up in the plane across it; where their potential energy is least, unless given.

    Raises:
        UnsupportedError: The chain is spatial, or the reference is at rest where nothing pulls.
    """
    return _problem(system, p, omega, near, share=0.5, sign=-1.0)


def whole_problem(system: System, p: Parameters | None = None, *, omega: float, near: Vector | None = None) -> Problem:
    """Orbits of any kind, with kappa = (lambda + 1/lambda) / 2 of M(T); arguments as in `half_problem`."""
    return _problem(system, p, omega, near, share=1.0, sign=1.0)


def _problem(system: System, p: Parameters | None, omega: float, near: Vector | None, *, share: float, sign: float) -> Problem:
    if not system.is_planar:
        raise UnsupportedError(
            "space", system.space, "a chain that can turn as a whole has periodic orbits up to that motion only", "use a planar chain"
        )
    flow, parameters, n, carts = system.function("propagate"), system.parameters(p), system.nq, system.cart_size
    phase = least_potential(system, p) if near is None else plane(system, p, near)
    size = 2 * n + 1
    identity = np.eye(2 * n)
    free = carts if sign > 0 else 0
    carry = carrier(flow, 2 * n, EPS, _STEPS, parameters)

    def evaluate(z: Vector) -> Evaluation:
        x, unfolding, rate = z[: 2 * n], float(z[-2]), float(z[-1])
        nothing = Evaluation(np.full(size, np.nan), np.full((size, size + 1), np.nan))
        if not (rate > 0 and np.all(np.isfinite(z))):
            return nothing
        time = share * 2 * np.pi / rate
        found = carry(x[:n], x[n:], time, identity)
        if found.outcome != "done":
            return nothing
        end = np.concatenate([found.q, found.v])
        damped = np.concatenate([np.zeros(n), x[n:]])
        at, along = phase(x)
        residual = np.append(end - sign * x + unfolding * damped, at)
        jacobian = np.zeros((size, size + 1))
        jacobian[:-1, :-2] = found.transition - sign * identity
        jacobian[n:-1, n:-2] += unfolding * np.eye(n)
        jacobian[:-1, -2] = damped
        jacobian[:-1, -1] = field(system, p, found.q, found.v) * (-time / rate)
        jacobian[-1, :-2] = along
        for k in range(free):
            residual[n + k], jacobian[n + k] = x[k], 0.0
            jacobian[n + k, k] = 1.0

        def made() -> tuple[Multipliers, PeriodMap]:
            out, back = frame(system, p, x[:n], x[n:])
            ahead = field(system, p, x[:n], x[n:])
            own = back @ ahead
            beside = across(own)
            symplectic = beside.T @ back @ (sign * found.transition) @ out @ beside
            turning = float(along @ ahead / (np.linalg.norm(along) * np.linalg.norm(ahead)))
            noise = np.abs(jacobian) @ np.abs(z) * (EPS * (1 + found.steps))
            return pairs(symplectic), PeriodMap(symplectic, gradient(own) @ back, turning, end, noise)

        return Evaluation(residual, jacobian, LateExtra(made))

    energy = energy_of(system, p)
    return Problem(
        evaluate=evaluate,
        names=(*_names(system.q_names, "q", n), *_names(system.v_names, "v", n), "unfolding", "omega"),
        scale=powers(np.concatenate([np.ones(n), np.full(n, omega), [1.0, omega]])),
        energy=energy and (lambda z: energy(z[:n], z[n : 2 * n])),
        error=frequency_error,
    )


def plane(system: System, p: Parameters | None, near: Vector) -> Phase:
    """The plane across the motion at a reference.

    Raises:
        UnsupportedError: The reference is at rest where nothing pulls.
    """
    reference = np.array(near, dtype=float)
    along = field(system, p, reference[: system.nq], reference[system.nq :])
    speed = float(np.linalg.norm(along))
    if not speed > 0:
        raise UnsupportedError("near", reference.tolist(), "is an equilibrium, which no orbit passes", "give a state of the orbit")
    unit = along / speed
    return lambda x: (float(unit @ (x - reference)), unit)


def least_potential(system: System, p: Parameters | None) -> Phase:
    """dV . v, which vanishes where the potential energy is least or greatest; dV = -M a of the chain at
    rest."""
    mass_of, parameters, n = system.function("mass_matrix"), system.parameters(p), system.nq
    still = np.zeros(n)

    def pull(q: Vector) -> Vector:
        return -np.asarray(mass_of(q, **parameters)) @ acceleration(system, q, still, None, p)

    def phase(x: Vector) -> tuple[float, Vector]:
        q, v = x[:n], x[n:]
        slope = pull(q)
        speed = float(np.max(np.abs(v)))
        if not speed > 0:
            return 0.0, np.append(still, slope)
        # The Hessian times v, by differences along v.
        h = _BESIDE / speed
        one, two = (pull(q + k * h * v) - pull(q - k * h * v) for k in (1, 2))
        return float(slope @ v), np.append((8 * one - two) / (12 * h), slope)

    return phase


def _names(names: tuple[str, ...], letter: str, count: int) -> tuple[str, ...]:
    return names or tuple(f"{letter}_{k + 1}" for k in range(count))
