"""Orbits that run the same way back, by shooting over half a period between two states that the reversal of
time leaves as they are.

A brake orbit is symmetric about its rest and about where it hangs straight. Orbits with one of both only are

    unequal brakes: (q_0, 0) -> (q_1, 0) in T/2, q_1 not -q_0:   v(T/2; q_0, 0) = 0, unknowns (q_0, omega),
    odd orbits:     (0, v_0) -> (0, v_1) in T/2, v_1 not -v_0:   q(T/2; 0, v_0) = 0, unknowns (v_0, omega),

N equations in N + 1 unknowns, no energy to unfold. With R = diag(1, -1) or its negative the monodromy is M(T)
= R Q^-1 R Q of Q = [a b; c d] over T/2 in canonical coordinates, so that

    kappa = (lambda + 1/lambda) / 2 = eig(1 + 2 b^T c) = eig(2 d^T a - 1).

The flow's own kappa = 1 has b g = 0 at a rest (nothing but the force is left of the flow), and c w = 0 where
the chain hangs straight. A cart keeps the middle of both its ends, x(0) + x(T/2) = 0; between two straight
chains it comes back, x(T/2) = 0, only without momentum.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from phichain.continuation import Evaluation, Problem
from phichain.continuation.linear import eigenvalues
from phichain.continuation.problem import LateExtra, Multipliers
from phichain.orbits.closed.canonical import frame
from phichain.orbits.closed.states import energy_of, field, gradient, unit
from phichain.orbits.quarter import EPS, complement, frequency_error, ordered, powers
from phichain.records import Held
from phichain.system import Parameters, System, Vector
from phichain.system.propagation import carrier

_STEPS = 40_000
"""Steps of half a period that are worth taking."""


@dataclass(frozen=True, eq=False)
class HalfMap(Held):
    """The variational equations from one state of symmetry to the next, in canonical coordinates of the N
    angles.

    Attributes:
        lost: The block (N, N), b of rests and c of straight chains, whose second null vector loses the
            symmetry.
        kept: The other of both (N, N).
        a: d theta(T/2) / d theta_0 (N, N).
        c: d p(T/2) / d theta_0 (N, N).
        d: d p(T/2) / d p_0 (N, N).
        begun: Unit vector along the flow at the start (N,): the right null vector of `lost`.
        ended: The same at T/2 (N,): its left null vector.
        slope: The energy's derivative (N,) by the unknowns that are no cart's and not omega, J.
        end: (q, v) at T/2 (2 nq,).
        noise: What rounding may have left in the residual (nq,).
    """

    lost: Vector
    kept: Vector
    a: Vector
    c: Vector
    d: Vector
    begun: Vector
    ended: Vector
    slope: Vector
    end: Vector
    noise: Vector

    def kappa(self) -> np.ndarray:
        """The N - 1 numbers (lambda + 1/lambda) / 2 besides the flow's own, the largest real part first."""
        if len(self.begun) == 1:
            return np.empty(0, complex)
        beside = complement(self.begun)
        return ordered(1 + 2 * eigenvalues((self.lost @ beside).T @ (self.kept @ beside)))


def reversible_problem(system: System, p: Parameters | None = None, *, rests: bool, omega: float) -> Problem:
    """Orbits between two rests, or between two passages through the straight chain.

    Args:
        system: A planar, undamped system whose `propagate` carries derivatives along, with `mass_matrix`.
        p: Runtime parameters.
        rests: Whether they are rests.
        omega: A frequency of the family, rad/s: its size.

    Raises:
        AbsentFunctionError: A function is missing.
    """
    flow, parameters, nq, carts = system.function("propagate"), system.parameters(p), system.nq, system.cart_size
    still, identity = np.zeros(nq), np.eye(2 * nq)
    own = slice(0, nq) if rests else slice(nq, 2 * nq)
    carry = carrier(flow, 2 * nq, EPS, _STEPS, parameters)

    def evaluate(z: Vector) -> Evaluation:
        rate = float(z[-1])
        nothing = Evaluation(np.full(nq, np.nan), np.full((nq, nq + 1), np.nan))
        if not (rate > 0 and np.all(np.isfinite(z))):
            return nothing
        q, v = (z[:-1], still) if rests else (still, z[:-1])
        half = np.pi / rate
        found = carry(q, v, half, identity)
        if found.outcome != "done":
            return nothing
        transition, end = found.transition, np.concatenate([found.q, found.v])
        ahead = field(system, p, found.q, found.v)
        # A cart's middle instead of its rate, which momentum keeps.
        rows = np.r_[0:carts, nq + carts : 2 * nq] if rests else np.arange(nq)
        residual, jacobian = end[rows], np.zeros((nq, nq + 1))
        jacobian[:, :-1] = transition[rows, own]
        jacobian[:, -1] = ahead[rows] * (-half / rate)
        if rests and carts:
            residual[0] += q[0]
            jacobian[0, 0] += 1.0

        def blocks() -> tuple[Multipliers, HalfMap]:
            out, own_back = frame(system, p, q, v)
            back = frame(system, p, found.q, found.v)[1]
            flows = own_back @ field(system, p, q, v), back @ ahead
            slope = (gradient(flows[0]) @ own_back)[own][carts:]
            noise = np.abs(jacobian) @ np.abs(z) * (EPS * (1 + found.steps))
            half_map = _map(back @ transition @ out, flows, rests, slope, end, noise)
            return half_map.kappa(), half_map

        return Evaluation(residual, jacobian, LateExtra(blocks))

    names = system.q_names or tuple(f"q_{k + 1}" for k in range(nq))
    rates = system.v_names or tuple(f"v_{k + 1}" for k in range(nq))
    energy = energy_of(system, p)
    return Problem(
        evaluate=evaluate,
        names=(*(names if rests else rates), "omega"),
        scale=powers(np.append(np.full(nq, 1.0 if rests else omega), omega)),
        energy=energy and (lambda z: energy(z[:-1], still) if rests else energy(still, z[:-1])),
        error=frequency_error,
    )


def _map(whole: Vector, flows: tuple[Vector, Vector], rests: bool, slope: Vector, end: Vector, noise: Vector) -> HalfMap:
    links = len(whole) // 2
    a, b, c, d = whole[:links, :links], whole[:links, links:], whole[links:, :links], whole[links:, links:]
    moving = slice(links, 2 * links) if rests else slice(0, links)
    begun, ended = (unit(flow[moving]) for flow in flows)
    return HalfMap(b if rests else c, c if rests else b, a, c, d, begun, ended, slope, end, noise)
