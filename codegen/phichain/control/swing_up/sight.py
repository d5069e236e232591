"""The observer along a planned motion: it finds out on the way by how much the parameters are wrong.

With d = x - x_r, theta the relative errors of the parameters (the same all along), A, B, E the exact derivatives of the step over one
sample, w white accelerations (and white inputs, if they are asked for) and v what encoders round off,

    d_{k+1} = A_k d_k + B_k u_k + E_k theta + w_k,      y_k = C d_k + v_k.

A swing moves the chain so much that its masses show: the Kalman filter of (d, theta), whose gains are known beforehand,

    [L; M] = P H^T (H P H^T + V)^-1,    P := (1 - [L; M] H) P (1 - [L; M] H)^T + [L; M] V [L; M]^T,    P := F P F^T + W,

H = [C, 0] and F = [[A, E], [0, 1]], estimates both. What remains of theta's covariance at the end is what the chain is held with there,
see `tremble`. The first row holds the stationary filter of the start, for a chain may be held there before it leaves: it says nothing of
theta.

Source: B. D. O. Anderson, J. B. Moore, Optimal Filtering (1979), chapters 3 and 8.
"""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_discrete_are

from phichain.control.equations.kalman import gathered
from phichain.control.rig.observer import Sensors, sizes_by_name, variances
from phichain.control.swing_up.chain import Chain, parameter_names
from phichain.control.swing_up.task import Task
from phichain.control.swing_up.tremble import bends, held_corrections
from phichain.errors import ControlError
from phichain.laws import Learning, ObserverAlong
from phichain.system import System, Vector

Linear = tuple[Vector, Vector, Vector]
BEYOND: Final = 2.0
"""How far theta may go, in largest errors that the law is made for: what is farther off comes of a sensor, not of a chain."""


def observer_along(
    chain: Chain, task: Task, path: Linear, end: tuple[Vector, Vector], hold: Vector, sensors: Sensors, errors: Vector, knots: NDArray[np.int_]
) -> ObserverAlong:
    """The observer along a motion.

    Args:
        chain: The chain.
        task: Its task.
        path: (A, B, E) at every sample of the motion.
        end: (A, B) at the target.
        hold: Gains with which the chain is held there (nu, nx).
        sensors: Steps and noise of the positions, and what disturbs the chain.
        errors: Largest relative errors of the runtime parameters (np,).
        knots: Samples at which the law's table has rows; the last is the target.

    Raises:
        ControlError: Other than the positions is to be measured, they are taken for exact, or they do not show the chain's motion.
    """
    A, B, E = path
    system = chain.system
    nq, nx = system.nq, system.nx
    V, drifts, push = _noises(system, task, sensors)
    C = np.eye(nq, nx)
    first, last = (_stationary(task, a, C, drifts + b @ push @ b.T, V) for a, b in ((A[0], B[0]), end))
    wrong = np.flatnonzero(errors)
    size = nx + wrong.size
    H, P = np.hstack([C, np.zeros((nq, wrong.size))]), np.zeros((size, size))
    P[:nx, :nx], P[nx:, nx:] = first, np.diag(errors[wrong] ** 2 / 3)
    whole, corrections = np.eye(size), np.empty((len(A), size, nq))
    for k, (a, b, e) in enumerate(zip(A, B, E[:, :, wrong], strict=True)):
        L = corrections[k] = np.linalg.solve(H @ P @ H.T + V, H @ P).T
        kept = np.eye(size) - L @ H
        P = kept @ P @ kept.T + L @ V @ L.T
        whole[:nx, :nx], whole[:nx, nx:] = a, e
        P = whole @ P @ whole.T
        P[:nx, :nx] += drifts + b @ push @ b.T
        P = (P + P.T) / 2
    at = knots[:-1]
    flows, drives = np.concatenate([A[at], end[0][None]])[:, nq:] - np.eye(nx)[nq:], np.concatenate([B[at], end[1][None]])[:, nq:]
    if not wrong.size:
        held = np.linalg.solve(C @ last @ C.T + V, C @ last).T
        return ObserverAlong(np.concatenate([corrections[at], held[None]]), flows, drives)
    bent = tuple(part[wrong] for part in bends(chain, np.concatenate([task.last, np.zeros(nq)]), task.sample))
    steps = np.sqrt(12 * np.diag(V))
    inside, outside = held_corrections(end, hold, (bent[0], bent[1]), P[nx:, nx:], (V, drifts + end[1] @ push @ end[1].T), task.sample, steps)
    learning = Learning(
        np.concatenate([corrections[at, nx:], np.zeros((1, wrong.size, nq))]), np.concatenate([E[at][:, nq:, wrong], np.zeros((1, nq, wrong.size))]),
        np.concatenate(bent, axis=2)[:, nq:], steps, inside, outside, BEYOND * errors[wrong], tuple(parameter_names(system)[k] for k in wrong),
    )  # fmt: skip
    # The last row ends the last straight line alone: at the target itself other corrections hold.
    return ObserverAlong(np.concatenate([corrections[at, :nx], corrections[-1:, :nx]]), flows, drives, learning)


def _noises(system: System, task: Task, sensors: Sensors) -> tuple[Vector, Vector, Vector]:
    """(V, W, D): covariances of what is measured, and of what a sample adds: W + B D B^T, white accelerations and white inputs."""
    nq, names = system.nq, system.q_names
    if sensors.measured is not None and tuple(sensors.measured) != names:
        raise ControlError(
            "measured", list(sensors.measured), "are not the positions, which the observer along a motion reads", f"measure {', '.join(names)}"
        )
    units = tuple("m" if i < system.cart_size else "rad" for i in range(nq))
    found = variances(sensors, names, units)
    if not np.all(found > 0):
        raise ControlError("resolution, noise", 0.0, "leave a measurement without error", "give one of them")
    sizes = sizes_by_name("disturbance", sensors.disturbance, (*names, *system.u_names), [1.0] * nq + [0.0] * system.nu, nq)
    drift, density = np.zeros((2 * nq, 2 * nq)), np.zeros((2 * nq, 2 * nq))
    drift[:nq, nq:], density[nq:, nq:] = np.eye(nq), np.diag(sizes[:nq] ** 2)
    return np.diag(found), np.asarray(gathered(drift, density, task.sample).high), np.diag(sizes[nq:] ** 2) / task.sample


def _stationary(task: Task, a: Vector, C: Vector, W: Vector, V: Vector) -> Any:
    """Covariance of what is expected before a measurement, after long."""
    try:
        return solve_discrete_are(a.T, C.T, W, V)
    except (np.linalg.LinAlgError, ValueError) as failure:
        raise ControlError(
            "disturbance", list(task.target), f"leaves no stationary observer: {failure}", "disturb every coordinate"
        ) from failure
