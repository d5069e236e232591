"""Corrections that hold a chain through encoders: wrong parameters do to a chain that trembles what noise would.

Where a count comes and goes the held chain trembles by d. With theta the relative errors of the parameters its state goes by

    d' = A d + B u + sum_k theta_k (A_k d + B_k u),      A_k, B_k the derivatives of A and B by theta_k,

and to an observer that knows A and B alone the sum is noise: large where wrong masses matter, next to nothing elsewhere, for what links do
to each other no mass gets wrong. White noise that is the same on every acceleration believes instead that the outermost link may leave its
place at any time, takes each of its counts for a start, and kicks the whole chain by the force. So the corrections are those of the Kalman filter
of the noise

    W = W_0 + (tau / T) sum_k <theta_k^2> (A_k X A_k^T + B_k U B_k^T),

X and U the covariances of d and u that these corrections leave themselves, found in turns; tau says how long the noise, which is none but a
motion of the chain's own, goes on in one direction.

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
"""tau, s. Of three links (docs/swingup.md), held for 4 s with masses within 10 %, rates stay within 0.05 rad per swing time in 93, 95 and 93 %
of the time at 10, 30 and 100 s, in 83 % without the sum; of 400 whole swing-ups 91 and 92 % at 30 and 100 s, and after a shorter time than
these the chain is not calm in time: observers that believe their chain are slow to see that it is elsewhere."""
STILL: Final = 3e-3
"""Share of the disturbance that is left, as what is beside wrong parameters."""
TURNS: Final = 8


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
    end: tuple[Vector, Vector], hold: Vector, bent: tuple[Vector, Vector], errors: Vector, V: Vector, W: Vector, sample: float
) -> Vector:
    """L (nx, ny) of the chain that is held at the target, whose first ny entries are measured.

    Args:
        end: (A, B) at the target.
        hold: Gains of its regulator (nu, nx).
        bent: (A_k, B_k) there.
        errors: Largest relative errors of the parameters (np,), some of them not zero.
        V: Covariance of what is measured (ny, ny).
        W: Covariance of what a sample adds, without wrong parameters (nx, nx).
        sample: T, s.
    """
    (A, B), (A_k, B_k) = end, bent
    C = np.eye(len(V), len(A))
    still, expected = STILL**2 * W, errors**2 / 3 * LASTING / sample
    noise = W
    for _ in range(TURNS):
        L = _corrections(A, C, noise, V)
        X, U = _trembling(A, B, hold, L, V)
        each = A_k @ X @ np.swapaxes(A_k, 1, 2) + B_k @ U @ np.swapaxes(B_k, 1, 2)
        noise = still + np.tensordot(expected, each, 1)
    return _corrections(A, C, noise, V)


def _corrections(A: Vector, C: Vector, W: Vector, V: Vector) -> Vector:
    P = solve_discrete_are(A.T, C.T, W, V)
    return np.asarray(np.linalg.solve(C @ P @ C.T + V, C @ P).T)


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
