"""How a chain is held through encoders whose parameters were found out on the way: what is left of their errors does to it what noise would.

Where a count comes and goes the held chain trembles by d. With theta the relative errors of the parameters its state goes by

    d' = A d + B u + sum_k theta_k (A_k d + B_k u),      A_k, B_k the derivatives of A and B by theta_k,

and to an observer whose theta is wrong by e the sum over e is noise: large where wrong masses matter, next to nothing elsewhere, for what
links do to each other no mass gets wrong. White noise that is the same on every acceleration believes instead that the outermost link may leave
its place at any time, takes each of its counts for a start, and kicks the whole chain by the force. So the corrections are those of the
Kalman filter of the noise

    W = W_0 + (tau / T) sum_kl <e_k e_l> (A_k X A_l^T + B_k U B_l^T),

X and U the covariances of d and u that these corrections leave themselves, found in turns; tau says how long the noise, which is none but a
motion of the chain's own, goes on in one direction.

A reading in steps of q is not wrong by chance: while a count stays it says the same again and again. What lies within half a step is therefore
corrected by the share of samples in which the count is another one, and what lies beyond, which no rounding explains, as by a sensor that
is nearly exact, for there the place is known: it is the edge between two counts. With P the covariance that is expected before a measurement,
V = q^2 / 12 and s_i the standard deviation of a rate in X,

    L_in = P C^T (C P C^T + V)^-1 diag(min(1, 20 (2 / pi)^1/2 s_i T / q_i)),      L_out,i = P c_i / (c_i^T P c_i + 0.03 V_ii).

Source: P. J. McLane, Optimal stochastic control of linear systems with state- and control-dependent disturbances, IEEE Trans. Automatic
Control 16 (1971) 793-798.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from scipy.linalg import solve_discrete_are, solve_discrete_lyapunov

from phichain.control.swing_up.chain import Chain
from phichain.system import Vector

LASTING: Final = 100.0
"""tau, s. After a shorter time chains are not calm in time: observers that believe their chain are slow to see that it is elsewhere."""
STILL: Final = 1e-3
"""Share of the disturbance that is left, as what is beside wrong parameters."""
TURNS: Final = 8
SAID_AGAIN: Final = 20.0
"""Samples that a count is worth when it changes. Of three links (docs/swingup.md), held with inputs weighed eightfold, 96.8, 98.0, 98.5 and 97.9 % of
the time is calm at 5, 10, 20 and 40, 95.9 % where all are worth the same."""
EDGE: Final = 0.03
"""Variance of the edge between two counts, over that of rounding; at a tenth of this some chains fall."""


def bends(chain: Chain, target: Vector, sample: float) -> tuple[Vector, Vector]:
    """A_k (np, nx, nx) and B_k (np, nx, nu): derivatives of the step's derivatives by the parameters' relative errors, at rest (nx,)."""
    import casadi as ca

    step = chain.step(sample)
    x, u, error = (ca.SX.sym(name, step.size1_in(k)) for k, name in enumerate(("x", "u", "e")))
    after = step(x, u, error)
    slopes = ca.horzcat(ca.jacobian(after, x), ca.jacobian(after, u))
    found = ca.Function("bends", [x, u, error], [ca.jacobian(ca.vec(slopes), error)])
    flat = np.array(found(target, np.zeros(u.numel()), np.zeros(error.numel())))
    whole = flat.T.reshape(error.numel(), slopes.size2(), slopes.size1()).transpose(0, 2, 1)
    return whole[:, :, : target.size], whole[:, :, target.size :]


def held_corrections(
    end: tuple[Vector, Vector], hold: Vector, bent: tuple[Vector, Vector], left: Vector, noises: tuple[Vector, Vector], sample: float, steps: Vector
) -> tuple[Vector, Vector]:
    """(L_in, L_out), each (nx, ny), of the chain that is held at the target, whose first ny entries are measured.

    Args:
        end: (A, B) at the target.
        hold: Gains of its regulator (nu, nx).
        bent: (A_k, B_k) there.
        left: Covariance of what is wrong of the estimated parameters (np, np).
        noises: (V, W): covariances of what is measured (ny, ny), and of what a sample adds without wrong parameters (nx, nx).
        sample: T, s.
        steps: q (ny,), those of what is measured.
    """
    (A, B), (V, W) = end, noises
    noise = W
    for _ in range(TURNS):
        P, L = _corrections(A, noise, V)
        X, U = _trembling(A, B, hold, L, V)
        noise = STILL**2 * W + LASTING / sample * (_bent(bent[0], X, left) + _bent(bent[1], U, left))
    P, L = _corrections(A, noise, V)
    rates = np.sqrt(np.diag(_trembling(A, B, hold, L, V)[0])[len(V) :])
    inside = L * np.minimum(1.0, SAID_AGAIN * np.sqrt(2 / np.pi) * rates * sample / steps)
    seen = P[:, : len(V)]
    return inside, seen / (np.diag(seen) + EDGE * np.diag(V))


def _bent(by: Vector, covariance: Vector, left: Vector) -> Vector:
    """sum_kl <e_k e_l> A_k X A_l^T."""
    found = np.einsum("kl,kij,jm,lnm->in", left, by, covariance, by, optimize=True)
    return np.asarray((found + found.T) / 2)


def _corrections(A: Vector, W: Vector, V: Vector) -> tuple[Vector, Vector]:
    """(P, L) of the stationary Kalman filter."""
    C = np.eye(len(V), len(A))
    P = solve_discrete_are(A.T, C.T, W, V)
    return P, np.asarray(np.linalg.solve(C @ P @ C.T + V, C @ P).T)


def _trembling(A: Vector, B: Vector, K: Vector, L: Vector, V: Vector) -> tuple[Vector, Vector]:
    """Covariances of state (nx, nx) and inputs (nu, nu) of the loop that what is measured wrong by V keeps going."""
    nx, ny = L.shape
    kept = np.eye(nx) - L @ np.eye(ny, nx)
    seen = np.hstack([L @ np.eye(ny, nx), kept])
    after = np.vstack([np.hstack([A, np.zeros((nx, nx))]) - B @ K @ seen, (A - B @ K) @ seen])
    driven = np.vstack([-B @ K @ L, (A - B @ K) @ L])
    both = solve_discrete_lyapunov(after, driven @ V @ driven.T)
    pushed = K @ seen
    return both[:nx, :nx], pushed @ both @ pushed.T + K @ L @ V @ L.T @ K.T
