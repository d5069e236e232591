"""Brake orbits of spatial chains that swing in a vertical plane, and what is beside them: in the plane and out of it.

Without springs these are a planar chain's orbits; springs between directions have another law than planar ones. With theta_k the angle of link k
from the hanging vertical, t_k = dq_k / d theta_k and y across the plane, the chain starts at rest and hangs straight after T/4. The spatial flow carries

    dq_k = a_k t_k, d omega_k = r_k y          in the plane: the quarter map of `quarter`,
    dq_k = b_k y,   d omega_k = -c_k t_k       out of it, c_k = b_k'.

Out of the plane nothing changes under theta -> -theta, so that these motions see half a period: with Q = [a b; c d] of the quarter in
canonical coordinates M(T/2) = S Q^-1 S Q, S = diag(1, -1), and kappa = (mu + 1/mu) / 2 = eig(2 d^T a - 1). Turning the plane about the vertical,
b_k = sin theta_k, comes to nothing where the chain is straight: a u = 0, mu = -1, lambda = 1. It is split off.

A free cart keeps the momentum zero in both directions: it is no unknown, its rate answers those of the links, M_cc x' = -M_c omega, and where it is
is no matter.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from phichain.continuation import Evaluation, Problem
from phichain.continuation.problem import LateExtra, Multipliers
from phichain.orbits.conical.turning import Turning, turning
from phichain.orbits.quarter import EPS, QuarterMap, complement, frequency_error, powers, quarter_map
from phichain.system import Parameters, System, Vector

METHOD = "in a plane"
NEEDED = ("forward_dynamics", "state_jacobian", "energy", "mass_matrix", "propagate")
"""Functions that are called."""
_STEPS = 20_000


@dataclass(frozen=True, eq=False)
class SpatialMap(QuarterMap):
    """The quarter map in the plane, with what lies across it.

    Attributes:
        within: kappa of motions in the plane (N - 1,).
        across: Those of motions out of it (N - 1,).
    """

    within: Multipliers
    across: Multipliers


def plane_problem(system: System, p: Parameters | None = None, *, omega: float) -> Problem:
    """theta(T/4; theta_0) = 0 with unknowns (theta_1 .. theta_N, omega), angles from the hanging vertical.

    Its multipliers are kappa = (mu + 1/mu) / 2 with lambda = mu^2: N - 1 in the plane and N - 1 out of it.

    Args:
        system: A spatial chain whose `propagate` carries derivatives along.
        p: Runtime parameters.
        omega: Frequency of the linear mode, rad/s: its size.
    """
    flow, mass_of, energy = (system.function(name) for name in ("propagate", "mass_matrix", "energy"))
    parameters, links, still = system.parameters(p), system.links, np.zeros(system.nv)
    carts = system.cart_size
    rest = turning(system, np.concatenate([np.zeros(int(system.has_cart) + links), [1.0]]))
    bottom = float(sum(energy(rest.q, still, **parameters)))

    def evaluate(z: Vector) -> Evaluation:
        rate = float(z[-1])
        if not (rate > 0 and np.all(np.isfinite(z))):
            return Evaluation(np.full(links, np.nan), np.full((links, links + 1), np.nan))
        q, within, across = _beside(system, z)
        start = np.asarray(mass_of(q, **parameters))
        for columns in (within, across):
            columns[system.nq :, links:] = _answered(start, columns[system.nq :, links:], carts)
        quarter = np.pi / (2 * rate)
        found = flow(q, still, 0.0, quarter, EPS, max_steps=_STEPS, transition=np.hstack([within, across]), **parameters)
        if found.outcome != "done":
            return Evaluation(np.full(links, np.nan), np.full((links, links + 1), np.nan))
        ended = found.q[carts:].reshape(links, 3)
        theta, theta_dot = np.arctan2(ended[:, 0], ended[:, 2]), found.v[carts:].reshape(links, 3)[:, 1]
        moved, turned = found.transition[carts : system.nq], found.transition[system.nq + carts :]
        # Along t at the end: where the chain hangs straight this is dq_x.
        along = moved.reshape(links, 3, -1)
        angles = np.cos(theta)[:, None] * along[:, 0] - np.sin(theta)[:, None] * along[:, 2]
        spins = turned.reshape(links, 3, -1)
        jacobian = np.column_stack([angles[:, :links], theta_dot * (-quarter / rate)])

        def maps() -> tuple[Multipliers, SpatialMap]:
            noise = np.abs(jacobian) @ np.abs(z) * (EPS * (1 + found.steps))
            end = np.asarray(mass_of(found.q, **parameters))
            begun = within[system.nq :, links:], across[system.nq :, links:]
            last = [_answered(end, part[system.nq :, -links:], carts) for part in (rest.odd, -rest.even)]
            roots = [np.linalg.cholesky(part.T @ start @ part) for part in begun]
            ends = [np.linalg.cholesky(part.T @ end @ part).T for part in last]
            half = 2 * links
            inside = quarter_map(np.vstack([angles[:, :half], spins[:, 1, :half]]), theta_dot, roots[0], ends[0], noise)
            outside = quarter_map(np.vstack([along[:, 1, half:], -spins[:, 0, half:]]), theta_dot, roots[1], ends[1], noise)
            turn = roots[1].T @ np.sin(z[:-1])
            rows = complement(turn / np.linalg.norm(turn)) if links > 1 else np.empty((1, 0))
            kappa = np.linalg.eigvals(2 * (outside.d @ rows).T @ (outside.a @ rows) - np.eye(links - 1)).astype(complex)
            within_kappa = inside.kappa()
            kappa = kappa[np.lexsort((kappa.imag, -kappa.real))]
            return np.concatenate([within_kappa, kappa]), SpatialMap(**vars(inside), within=within_kappa, across=kappa)

        return Evaluation(theta, jacobian, LateExtra(maps))

    def height(z: Vector) -> float:
        return float(sum(energy(at_rest(system, z).q, still, **parameters))) - bottom

    return Problem(
        evaluate=evaluate,
        names=(*(f"theta_{k + 1}" for k in range(links)), "omega"),
        scale=powers(np.append(np.ones(links), omega)),
        energy=height,
        error=frequency_error,
    )


def _beside(system: System, z: Vector) -> tuple[Vector, Vector, Vector]:
    """The chain at rest at z (nq,), and small motions in its plane and out of it (nx, 2 N): displacements, then rates."""
    links, nq = system.links, system.nq
    at = at_rest(system, z)
    within, across = np.zeros((2, system.nx, 2 * links))
    angles = slice(at.count - links, at.count)
    within[:, :links], across[:, :links] = at.even[:, angles], at.odd[:, angles]
    within[nq:, links:], across[nq:, links:] = at.odd[nq:, -links:], -at.even[nq:, -links:]
    return at.q, within, across


def at_rest(system: System, z: Vector) -> Turning:
    """The chain at rest at the angles of z, a cart at 0."""
    return turning(system, np.concatenate([np.zeros(int(system.has_cart)), z[:-1], [0.0]]))


def _answered(mass: Vector, rates: Vector, carts: int) -> Vector:
    """Rates (nv, m) of the links with those of a cart that leave no momentum."""
    if not carts:
        return rates
    return np.vstack([-np.linalg.solve(mass[:carts, :carts], mass[:carts, carts:] @ rates[carts:]), rates[carts:]])
