"""One record of each kind, its numbers all different."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from phichain.continuation import Branch, Special
from phichain.control import Gains
from phichain.fractional import Differintegral, Propagation
from phichain.motion import Crossing, Trajectory

M, NQ = 5, 2
VALUES = {"mass": (0.4, 0.3), "gravity": 9.81}
"""Runtime parameters."""


def trajectory() -> Trajectory:
    """A record with every entry, its numbers all different."""
    numbers = iter(np.arange(1.0, 1000.0))

    def some(*shape: int) -> np.ndarray:
        return np.array([next(numbers) for _ in range(int(np.prod(shape)))]).reshape(shape) / 7

    return Trajectory(
        name="pair", space="planar", t=some(M), q=some(M, NQ), v=some(M, NQ), a=some(M, NQ), u=some(M, 1), kinetic=some(M),
        potential=some(M), length_error=None, tangency_error=None, events=(Crossing("low", 0.5, some(2 * NQ), True),),
        method="taylor", status="complete", reason="as asked", tol=1e-9, counts={"steps": 3}, q_names=("theta_1", "theta_2"),
        v_names=("theta_dot_1", "theta_dot_2"), u_names=("torque_1",), error=some(M), holds_until=0.25, lengths=some(2), angles="relative", digest="d1", p=VALUES,
    )  # fmt: skip


def branch() -> Branch:
    """A branch of three points with one event."""
    points, multipliers = np.arange(9.0).reshape(3, 3) / 7, np.exp(1j * np.arange(6.0)).reshape(3, 2)
    return Branch(
        name="mode 1", names=("a", "b", "omega"), points=points, arclength=np.arange(3.0), tangent=points + 1,
        residual=np.ones(3), iterations=np.array([1, 2, 3]), scale=np.ones(3), energy=None,
        events=(Special("fold", 1, points[1], 0.5, 1e-12, multipliers[0]),), status="points",
        reason="max_points = 3 reached", multipliers=multipliers, tol=1e-11, digest="d2", method="shooting", mode=1, p=VALUES,
    )  # fmt: skip


def gains() -> Gains:
    """A regulator of a single link."""
    square, pair = np.arange(4.0).reshape(2, 2), np.array([-1 + 1j, -1 - 1j])
    return Gains(
        name="one", space="planar", cart=0, s=(-1,), equilibrium=np.array([np.pi]), K=square[:1], S=square, A=square,
        B=square[:, :1], Q=square, R=square[:1, :1], poles=pair, modes=pair[:1], margins=np.ones(1), residual=1e-16,
        iterations=2, state_names=("theta_1", "theta_1_dot"), input_names=("torque_1",), digest="d4", p=VALUES,
    )  # fmt: skip


def differintegral() -> Differintegral:
    """Two orders of a signal of one channel."""
    return Differintegral(np.arange(4.0), np.array([-1.0, 0.5]), np.arange(8.0).reshape(2, 4) / 7, 4, 3, False)


def propagation() -> Propagation:
    """One path of a chain of two links."""
    forces, surfaces = np.arange(6.0).reshape(3, 2), np.arange(12.0).reshape(3, 2, 2)
    return Propagation(
        "pair", np.arange(3.0), np.array([0.0, 1.0]), np.array([-2.0, -1.0]), {"total": forces}, {"total": surfaces},
        {"total": surfaces + 1}, ("theta_1", "theta_2"), True, 4, "d3", VALUES,
    )  # fmt: skip


RECORDS: dict[str, Callable[[], Any]] = {
    "Trajectory": trajectory, "Branch": branch, "Gains": gains, "Differintegral": differintegral, "Propagation": propagation,
}  # fmt: skip
OPTIONAL = {
    "Trajectory": ("u", "kinetic", "potential", "length_error", "tangency_error", "error", "holds_until", "lengths", "angles", "digest", "p"),
    "Branch": ("energy", "multipliers", "event_multipliers", "tol", "p", "digest", "method", "mode"),
    "Gains": ("digest", "sample", "error", "p"),
    "Differintegral": (),
    "Propagation": ("digest", "params"),
}
"""What a record may be without, or was written without before."""
