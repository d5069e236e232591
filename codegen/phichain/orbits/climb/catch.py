"""The regulator that takes the chain up where its family ends, and the ellipsoid in which it does.

A weak input reaches its limit within a hair of the unstable directions, while along the stable ones the ellipsoid of the linear law,
V = z^T S z / rho <= 1, is hundreds of times as long: the chain enters it there, on its way in, where rates are high and the linear
model errs by more than the ellipsoid is thick. The level on the way home is then not that of the linear law: it rises first. So

- the ellipsoid is narrowed, V + z^T P z / r^2 with F^T P F - P = -Q of the closed loop, until all starts on it come home on the whole
  equations with the input clipped, and
- it is left only at `LEAVE`, several times the largest level that was met on the way.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from scipy.linalg import expm, solve_discrete_lyapunov

from phichain.control import Gains, gain_table, lqr
from phichain.errors import ControlError
from phichain.laws import GainTable, StateFeedback
from phichain.laws.family import LEAVE
from phichain.orbits.climb.motion import Equations
from phichain.system import System, Vector

COSTS: Final = (1.0, 10.0, 30.0, 100.0, 300.0)
"""Weights of the input, in squared gravity torques, of which the regulator of the target takes the one that reaches farthest."""
REACH: Final = 0.5
"""Largest angle within the ellipsoid, rad, that is tried first."""
NARROWER: Final = 0.8
"""Factor from one to the next."""
LEAST: Final = 1e-4
"""Largest angle, rad, below which none is tried."""
BEYOND: Final = 1.5
"""Level that starts are taken from: the chain has a state of its own, and parameters."""
ROOM: Final = 0.25
"""Share of `LEAVE` that the level may reach on the way home."""
HOME: Final = 0.01
"""Level at which a start has come home."""
DECAYS: Final = 6.0
"""How long it may take, in time constants of the slowest pole."""
THIN: Final = (1.0, 0.3, 0.1, 0.01)
"""How far across starts are, from all over the ellipsoid to its ends."""
STARTS: Final = 48
"""Starts of each kind; with every one its mirror image goes home alike."""


def regulators(system: System, signs: tuple[int, ...], weights: Vector, torque: float, limit: float, sample: float) -> list[tuple[Gains, GainTable]]:
    """Regulators of the target by the weight of their input, each with a table of one."""
    every = [lqr(system, signs, weights, cost / torque**2, sample=sample) for cost in COSTS]
    return [(gains, gain_table([gains], limit=limit, reach=REACH)) for gains in every]


def narrowed(equations: Equations, gains: Gains, table: GainTable, weights: Vector) -> Vector:
    """W (nx, nx) of the ellipsoid |W w(x - target)|^2 <= 1 from which the clipped law brings the chain home.

    Args:
        equations: The chain's motion.
        gains: The regulator.
        table: The table of it, with its limit.
        weights: Q (nx,), of the state's entries.

    Raises:
        ControlError: No ellipsoid of a useful size is one.
    """
    linear, K = np.array(table.shapes[0]), np.array(table.gains[0])
    nx, nu = len(weights), len(K)
    held = expm(gains.sample * np.block([[gains.A, gains.B], [np.zeros((nu, nx + nu))]]))
    settling = solve_discrete_lyapunov((held[:nx, :nx] - held[:nx, nx:] @ K).T, np.diag(weights))
    settling *= np.max(np.diag(np.linalg.inv(settling))[: nx // 2])
    reach = REACH
    while reach >= LEAST:
        level = linear.T @ linear + settling / reach**2
        if _comes_home(equations, gains, table, level):
            return np.asarray(np.linalg.cholesky(level).T)
        reach *= NARROWER
    raise ControlError(
        "limit", table.high[0], "holds the target from nowhere near: its linear regulator saturates at once", "give a larger one, or a shorter sample"
    )


def state_feedback(table: GainTable) -> StateFeedback:
    """The one regulator of a table."""
    return StateFeedback(
        table.name, table.digest, table.state_names, table.state_units, table.input_names, table.input_units, table.targets[0], table.rest[0],
        table.gains[0], table.wraps, table.low, table.high, table.sample, p=table.p,
    )  # fmt: skip


def _comes_home(equations: Equations, gains: Gains, table: GainTable, level: Vector) -> bool:
    """Whether every start on the ellipsoid does, its level z^T level z never beyond `ROOM` of where the target is let go."""
    target, K, high = np.array(table.targets[0]), np.array(table.gains[0])[0], table.high[0]
    z = _starts(level)
    x, h = target + z, np.full(len(z), gains.sample)
    for _ in range(int(np.ceil(DECAYS / gains.decay / gains.sample))):
        z = x - target
        levels = np.einsum("ni,ij,nj->n", z, level, z)
        if not np.all(levels <= ROOM * LEAVE):
            return False
        x = equations.step(x, h, np.clip(-z @ K, -high, high))
    z = x - target
    return bool(np.all(np.einsum("ni,ij,nj->n", z, level, z) <= HOME))


def _starts(level: Vector) -> Vector:
    """Deviations on an ellipsoid (starts, nx): all over it, and ever closer to the ends of its long axes, where the chain comes in."""
    sizes, axes = np.linalg.eigh(level)
    nx = len(sizes)
    drawn = np.random.default_rng(1).standard_normal((len(THIN), STARTS, nx))
    across = np.where(np.arange(nx) < nx // 2, 1.0, np.array(THIN)[:, None, None])
    unit = (drawn * across).reshape(-1, nx)
    unit *= np.sqrt(BEYOND) / np.linalg.norm(unit, axis=1, keepdims=True)
    return np.asarray((unit / np.sqrt(sizes)) @ axes.T)
