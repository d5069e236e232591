"""Gains along a planned motion: time-varying LQR, and better ones where parameters are known to errors alone.

With d = x - x_r, theta the relative errors of the parameters, and A, B, E the exact derivatives of the step over one sample,

    d_{k+1} = A_k d_k + B_k u_k + E_k theta + noise,      theta the same all along.

The law u = -K_k d knows nothing of theta, but d does: what has been off so far says what will push next. The gains minimise the
expected sum of d^T Q d + u^T R u, for starts and errors of the asked sizes, among all laws that look at d alone. With P the
covariance of (d, theta) and S the cost to go of both,

    K = (R + B^T S_dd B)^-1 B^T [S_dd A + (S_dd E + S_dtheta) M],    M = P_thetad P_dd^-1,

P forwards under the gains, S backwards under P, in turns; without errors it is the linear quadratic regulator at once.

Source: W. S. Levine, M. Athans, On the determination of the optimal constant output feedback gains for linear multivariable
systems, IEEE Trans. Automatic Control 15 (1970) 44-48; here in finite time and with gains that vary.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from scipy.linalg import solve_discrete_are

from phichain.control.rig.observer import Sensors
from phichain.control.swing_up.chain import Chain
from phichain.control.swing_up.plan import Plan
from phichain.control.swing_up.sight import observer_along
from phichain.control.swing_up.task import Task
from phichain.errors import ControlError
from phichain.laws import StateFeedback, TrajectoryLaw
from phichain.system import Vector
from phichain.system.angles import absolute_angles

TURNS: Final = 6
CALMER: Final = 2.0
"""How much more the inputs weigh where a chain is held through an observer: what a count that comes or goes does to the estimate, the gains
hand on to the chain. Of three links (docs/swingup.md) 97.2, 97.7 and 98.1 % of 600 to 1200 swing-ups end calm at 1, 2 and 4, but at 4 one in two
hundred does not hold: its cart is too far away."""
_MILLISECOND: Final = 1e-3
_FLOOR: Final = 1e-14
Linear = tuple[Vector, Vector, Vector]


@dataclass(frozen=True)
class Design:
    """What gains are made for; all in units of the chain's own.

    Attributes:
        input: Weight of the inputs, over the squares of what would accelerate the chain as its weight does.
        noise: Unmodelled change of a rate in a millisecond, over one radian (one metre) per swing time.
    """

    input: float
    noise: float = 3e-4


def law_along(
    chain: Chain, task: Task, plan: Plan, design: Design, errors: Vector, spread: float, stride: int = 5, tube: float = 1.0,
    sensors: Sensors | None = None,
) -> TrajectoryLaw:  # fmt: skip
    """The law that leads the chain along a plan and holds it at its target.

    Args:
        chain: The chain.
        task: Its task.
        plan: The motion.
        design: What the gains are made for.
        errors: Largest relative errors of the runtime parameters (np,).
        spread: Largest error of the angles at the start, rad.
        stride: Samples from one knot of the table to the next.
        tube: Largest deviation of the angles with which the law goes on, rad.
        sensors: How positions are measured, for a law that reads them through an observer; None for one that reads the state.

    Raises:
        ControlError: The target cannot be held by these inputs, or sensors are no good.
    """
    system = chain.system
    derivatives = chain.derivatives(task.sample)
    path = linear_path(derivatives, plan.x, plan.u)
    weights = catch_gains(chain, task, derivatives, design)
    gains = regulated(path, *weights)
    if np.any(errors):
        gains = _expecting(path, gains, weights, _spreads(system, errors, spread), _noise(chain, task, design))
    hold = _catch(derivatives, task, weights[0], weights[1] * (1.0 if sensors is None else CALMER))[1]
    knots = np.arange(0, len(plan.x), stride)
    states, inputs = plan.x[knots].copy(), np.vstack([plan.u[knots[:-1]], np.zeros((1, system.nu))])
    states[-1] = np.concatenate([task.last, np.zeros(system.nv)])
    table = np.concatenate([gains[knots[:-1]], hold[None]])
    observer = None
    if sensors is not None:
        end = tuple(np.array(part) for part in derivatives(states[-1], np.zeros(system.nu))[:2])
        observer = observer_along(chain, task, path, (end[0], end[1]), hold, sensors, errors, knots)
    return TrajectoryLaw(
        _regulator(system, task, states[-1], hold), stride * task.sample, states, inputs, table, tube=tube, rail=task.rail,
        observer=observer,
    )  # fmt: skip


def linear_path(derivatives: Any, x: Vector, u: Vector) -> Linear:
    """(A, B, E) at every sample: (M, nx, nx), (M, nx, nu), (M, nx, np)."""
    M, nx = len(u), x.shape[1]
    found = derivatives.map(M)(x[:M].T, u.T)
    A, B, E = (np.array(part).reshape(nx, M, -1).transpose(1, 0, 2) for part in found)
    return np.ascontiguousarray(A), np.ascontiguousarray(B), np.ascontiguousarray(E)


def catch_gains(chain: Chain, task: Task, derivatives: Any, design: Design) -> tuple[Vector, Vector, Vector]:
    """(Q, R, S): the weights, and the cost to go of the regulator at the target.

    Raises:
        ControlError: There is no such regulator.
    """
    system = chain.system
    nq, cart = system.nq, system.cart_size
    to_absolute = np.eye(nq)
    to_absolute[cart:, cart:] = absolute_angles(system, np.hstack([np.zeros((nq - cart, cart)), np.eye(nq - cart)])).T
    if cart:
        to_absolute[0, 0] = 1.0 / (task.rail if np.isfinite(task.rail) else float(np.sum(system.number("length"))))
    square = to_absolute.T @ to_absolute
    Q = np.block([[square, np.zeros((nq, nq))], [np.zeros((nq, nq)), task.swing**2 * square]])
    R = np.diag(design.input / chain.push**2)
    scale = task.sample / _MILLISECOND
    return Q * scale, R * scale, _catch(derivatives, task, Q * scale, R * scale)[0]


def _catch(derivatives: Any, task: Task, Q: Vector, R: Vector) -> tuple[Vector, Vector]:
    """(S, K) of the sampled regulator at the target."""
    still = np.concatenate([task.last, np.zeros(task.last.size)])
    A, B = (np.array(part) for part in derivatives(still, np.zeros(len(R)))[:2])
    try:
        S = solve_discrete_are(A, B, Q, R)
    except (np.linalg.LinAlgError, ValueError) as failure:
        raise ControlError(
            "target", list(task.target), f"cannot be held by these inputs: {failure}", "actuate more, or choose another target"
        ) from failure
    return S, np.linalg.solve(R + B.T @ S @ B, B.T @ S @ A)


def regulated(path: Linear, Q: Vector, R: Vector, S: Vector) -> Vector:
    """Gains (M, nu, nx) of the time-varying linear quadratic regulator that ends with the cost S."""
    A, B, _ = path
    gains = np.empty((len(A), B.shape[2], A.shape[1]))
    for k in range(len(A) - 1, -1, -1):
        a, b = A[k], B[k]
        inner = R + b.T @ S @ b
        gains[k] = np.linalg.solve(inner, b.T @ S @ a)
        S = Q + a.T @ S @ a - gains[k].T @ inner @ gains[k]
        S = (S + S.T) / 2
    return gains


def _expecting(path: Linear, gains: Vector, weights: tuple[Vector, Vector, Vector], first: Vector, noise: Vector) -> Vector:
    """Gains that expect the errors: P forwards and S backwards, in turns."""
    (A, B, E), (Q, R, S_end) = path, weights
    M, nx, size = len(A), A.shape[1], len(first)
    both = np.zeros((M, size, size))
    both[:, :nx, :nx], both[:, :nx, nx:], both[:, nx:, nx:] = A, E, np.eye(size - nx)
    end = np.zeros((size, size))
    end[:nx, :nx] = S_end
    for _ in range(TURNS):
        P, guess = first + noise, np.empty((M, size - nx, nx))
        for k in range(M):
            inner = P[:nx, :nx]
            guess[k] = np.linalg.solve(inner + _FLOOR * np.trace(inner) * np.eye(nx), P[:nx, nx:]).T
            closed = both[k].copy()
            closed[:nx, :nx] -= B[k] @ gains[k]
            P = closed @ P @ closed.T + noise
        S = end
        for k in range(M - 1, -1, -1):
            pulled = B[k].T @ S[:nx]
            whole = np.linalg.solve(R + pulled[:, :nx] @ B[k], pulled @ both[k])
            gains[k] = whole[:, :nx] + whole[:, nx:] @ guess[k]
            closed = both[k].copy()
            closed[:nx, :nx] -= B[k] @ gains[k]
            S = closed.T @ S @ closed
            S[:nx, :nx] += Q + gains[k].T @ R @ gains[k]
            S = (S + S.T) / 2
    return gains


def _spreads(system: Any, errors: Vector, spread: float) -> Vector:
    """Covariance of (d, theta) at the start, both uniform within their bounds."""
    sizes = np.zeros(system.nx + errors.size)
    sizes[system.cart_size : system.nq] = spread
    sizes[system.nx :] = errors
    return np.diag(sizes**2 / 3)


def _noise(chain: Chain, task: Task, design: Design) -> Vector:
    """Covariance of what is not modelled, of one sample."""
    system = chain.system
    sizes = np.zeros(system.nx + chain.parameters.size)
    rate = design.noise / task.swing * np.sqrt(task.sample / _MILLISECOND)
    sizes[: system.nq], sizes[system.nq : system.nx] = task.sample * rate, rate
    return np.diag(sizes**2)


def _regulator(system: Any, task: Task, target: Vector, hold: Vector) -> StateFeedback:
    cart = system.cart_size
    is_pushed = [name in ("force", "acceleration") for name in system.u_names]
    units = ["m/s^2" if name == "acceleration" else "N" if pushed else "N m" for name, pushed in zip(system.u_names, is_pushed, strict=True)]
    return StateFeedback(
        name=system.name, digest=system.digest, state_names=(*system.q_names, *system.v_names),
        state_units=(*("m",) * cart, *("rad",) * system.links, *("m/s",) * cart, *("rad/s",) * system.links),
        input_names=system.u_names, input_units=tuple(units), target=tuple(target), rest=(0.0,) * system.nu,
        gains=tuple(map(tuple, hold)), wraps=tuple(cart <= i < system.nq for i in range(system.nx)),
        low=tuple(-task.limit), high=tuple(task.limit), sample=task.sample, p=system.values(),
    )  # fmt: skip
