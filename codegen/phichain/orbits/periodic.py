"""Orbits that need not stand still, by shooting: over half a period where theta(t + T/2) = -theta(t), else over a whole one.

With x = (q, v), the flow phi_t and s = -1 over T/2 or s = 1 over T the unknowns (x_0, eps, omega) fulfil

    phi_(T/2 or T)(x_0) - s x_0 + eps w(x_0) = 0,   f(x_r) . (x_0 - x_r) = 0,   w = (0, v_0).

The energy is conserved, so that one of the closing equations follows from the others; eps unfolds it (a damper would: dH . w is
twice the kinetic energy, not zero where the chain moves) and vanishes on every orbit. The last equation chooses the phase: x_0 stays in
the plane across the motion at a reference x_r. What is left is a curve of orbits.

Source: F. Munoz-Almaraz et al., Continuation of periodic orbits in conservative and Hamiltonian systems, Physica D 181 (2003) 1-38.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from phichain.continuation import Evaluation, Problem
from phichain.continuation.problem import LateExtra, Multipliers
from phichain.errors import UnsupportedError
from phichain.orbits.quarter import EPS
from phichain.system import Parameters, System, Vector, acceleration

_STEPS = 40_000
"""Steps of a period that are worth taking."""


def half_problem(system: System, p: Parameters | None = None, *, near: Vector, omega: float) -> Problem:
    """Orbits with theta(t + T/2) = -theta(t), with kappa = (mu + 1/mu) / 2 of P = -M(T/2), lambda = mu^2.

    Args:
        system: A planar, undamped chain on a fixed base whose `propagate` carries derivatives along.
        p: Runtime parameters.
        near: A state x_r = (q, v) beside which the first orbit passes, the chain moving there (2 N,).
        omega: Its frequency, rad/s: its size.

    Raises:
        UnsupportedError: The chain is on a cart, or the reference is at rest where nothing pulls.
    """
    return _problem(system, p, near, omega, share=0.5, sign=-1.0)


def whole_problem(system: System, p: Parameters | None = None, *, near: Vector, omega: float) -> Problem:
    """Orbits of any kind, with kappa = (lambda + 1/lambda) / 2 of M(T); arguments as in `half_problem`."""
    return _problem(system, p, near, omega, share=1.0, sign=1.0)


def _problem(system: System, p: Parameters | None, near: Vector, omega: float, *, share: float, sign: float) -> Problem:
    if system.has_cart or not system.is_planar:
        raise UnsupportedError(
            "base", system.base, "a chain that can drift or turn as a whole has periodic orbits up to that motion only",
            "use a planar chain on a fixed base, or quarter_problem for brake orbits on a cart",
        )  # fmt: skip
    flow, parameters, n = system.function("propagate"), system.parameters(p), system.nq
    reference = np.array(near, dtype=float)
    along = _field(system, p, reference)
    speed = float(np.linalg.norm(along))
    if not speed > 0:
        raise UnsupportedError("near", reference.tolist(), "is an equilibrium, which no orbit passes", "give a state of the orbit")
    along = along / speed

    def evaluate(z: Vector) -> Evaluation:
        x, unfolding, rate = z[: 2 * n], float(z[-2]), float(z[-1])
        size = 2 * n + 1
        if not (rate > 0 and np.all(np.isfinite(z))):
            return Evaluation(np.full(size, np.nan), np.full((size, size + 1), np.nan))
        time = share * 2 * np.pi / rate
        found = flow(x[:n], x[n:], 0.0, time, EPS, max_steps=_STEPS, transition=np.eye(2 * n), **parameters)
        if found.outcome != "done":
            return Evaluation(np.full(size, np.nan), np.full((size, size + 1), np.nan))
        end = np.concatenate([found.q, found.v])
        damped = np.concatenate([np.zeros(n), x[n:]])
        residual = np.append(end - sign * x + unfolding * damped, along @ (x - reference))
        jacobian = np.zeros((size, size + 1))
        jacobian[:-1, :-2] = found.transition - sign * np.eye(2 * n)
        jacobian[n:-1, n:-2] += unfolding * np.eye(n)
        jacobian[:-1, -2] = damped
        jacobian[:-1, -1] = _field(system, p, end) * (-time / rate)
        jacobian[-1, :-2] = along
        return Evaluation(residual, jacobian, LateExtra(_stability(sign * found.transition)))

    return Problem(
        evaluate=evaluate,
        names=(*_names(system.q_names, "q", n), *_names(system.v_names, "v", n), "unfolding", "omega"),
        scale=np.concatenate([np.ones(n), np.full(n, _power(omega)), [1.0, _power(omega)]]),
        energy=_energy(system, p),
    )


def _field(system: System, p: Parameters | None, x: Vector) -> Vector:
    """x' (2 N,)."""
    n = system.nq
    return np.concatenate([x[n:], acceleration(system, x[:n], x[n:], None, p)])


def _stability(monodromy: Vector) -> Callable[[], tuple[Multipliers, Vector]]:
    """kappa (N - 1,) of a symplectic map without its flow and its energy, which have mu = 1 twice, made when asked for."""

    def made() -> tuple[Multipliers, Vector]:
        mu = np.linalg.eigvals(monodromy).astype(complex)
        kappa = ((mu + 1 / mu) / 2)[np.argsort(np.abs(mu - 1))[2:]]
        ordered = kappa[np.lexsort((kappa.imag, -kappa.real))]
        # mu and 1/mu have the same.
        return np.asarray(ordered[::2], complex), monodromy

    return made


def _energy(system: System, p: Parameters | None) -> Callable[[Vector], float] | None:
    """Energy of an orbit, J, counted from the hanging rest; None without an energy callable."""
    if not system.has("energy"):
        return None
    n, parameters = system.nq, system.parameters(p)
    bottom = float(sum(system.energy(np.zeros(n), np.zeros(n), **parameters)))
    return lambda z: float(sum(system.energy(z[:n], z[n : 2 * n], **parameters))) - bottom


def _names(names: tuple[str, ...], letter: str, count: int) -> tuple[str, ...]:
    return names or tuple(f"{letter}_{k + 1}" for k in range(count))


def _power(size: float) -> float:
    return float(np.exp2(np.round(np.log2(size))))
