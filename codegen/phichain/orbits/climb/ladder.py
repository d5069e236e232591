"""Rungs: the orbits of a family from rest to an equilibrium, each by the states along a quarter of its period.

A family that leads up to an equilibrium ends in a motion that takes for ever, and shooting from the brake ends before it, where what
grows by e^(lambda T / 4) loses the last digit. Beyond, orbits are found by multiple shooting: a quarter of the period in SEGMENTS parts,
the brake's first angle given, its others, the states between, the rate at the bottom and the period to be found. Nearer brakes follow
from farther ones: the deviation shrinks by a factor, the chain stays longer by its logarithm over lambda.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from phichain.continuation import Branch
from phichain.errors import ConvergenceError, UnsupportedError
from phichain.orbits.climb.motion import Equations
from phichain.records import Held
from phichain.system import System, Vector
from phichain.system.angles import scene_angles

SEGMENTS: Final = 16
"""Parts of a quarter period; the fastest upright modes grow by e^10 in one where the whole grows by e^160."""
FINE: Final = 20
"""States kept in each part."""
STEPS: Final = 6
"""Steps of integration between two states."""
NEARER: Final = 0.75
"""Factor from brake to brake beyond the branch."""
MOST: Final = 60
"""Orbits beyond the branch: the last brake is 3e-8 of the branch's last from the equilibrium."""
NEAR: Final = 0.4
"""Largest angle of a brake from its equilibrium, rad, from which orbits beyond the branch are looked for."""
CLOSED: Final = 1e-9


@dataclass(frozen=True, eq=False)
class Ladder(Held):
    """Orbits by rising energy.

    Attributes:
        states: From brake to bottom (orbits, SEGMENTS * FINE + 1, nx), evenly spaced in time.
        periods: (orbits,), s.
        energies: (orbits,), J above the hanging chain.
        target: The equilibrium that they lead to (nx,), at rest.
        signs: The same, +1 hanging, -1 upright.
    """

    states: Vector
    periods: Vector
    energies: Vector
    target: Vector
    signs: tuple[int, ...]


def ladder(system: System, branch: Branch, equations: Equations, is_near: Callable[[Vector], bool]) -> Ladder:
    """The orbits of a saved family, and those beyond it until a brake is near its equilibrium.

    Args:
        system: The chain.
        branch: A family of brake orbits that was traced by shooting.
        equations: The chain's motion.
        is_near: Whether a brake (nx,) is near enough for the regulator that is to catch the chain there.

    Raises:
        UnsupportedError: The family is of other orbits, falls in energy, begins far from rest, or ends far from any equilibrium.
        ConvergenceError: Orbits beyond the branch were not found.
    """
    if branch.method != "shooting" or branch.closing not in ("", "quarter") or system.has_cart:
        raise UnsupportedError("branch", branch.closing or branch.method, "is no family of brake orbits of a chain on a fixed base",
                               'trace one with method = "shooting"')  # fmt: skip
    z = np.array(branch.points)
    energies = np.array(branch.energy)
    falling = np.flatnonzero(np.diff(energies) <= 0)
    if falling.size:
        raise UnsupportedError(
            "branch", f"{branch.scene}, mode {branch.mode}", f"turns at {energies[falling[0]]:.6g} J: its energy falls from there, and no "
            "climb follows it", "trace another mode, whose energy rises all the way to an equilibrium"
        )  # fmt: skip
    half = system.nq
    last = z[-1, :half]
    phi = _absolute(system, last)
    turns = np.round(phi / np.pi)
    target = scene_angles(system, turns * np.pi)
    signs = tuple(int(1 - 2 * (int(turn) % 2)) for turn in turns)
    if np.max(np.abs(phi - turns * np.pi)) > NEAR or all(sign > 0 for sign in signs):
        raise UnsupportedError(
            "branch", f"{energies[-1]:.6g} J", "is its last energy, and no equilibrium is near its last brake",
            f"trace it further, until a brake is within {NEAR} rad of an equilibrium"
        )  # fmt: skip
    periods = 2 * np.pi / z[:, half]
    rows, times = [*_quarters(equations, z[:, :half], periods)], list(periods)
    x_end = np.concatenate([target, np.zeros(half)])
    slow = _slowest(equations, x_end)
    while not is_near(rows[-1][0]):
        if len(rows) - len(z) >= MOST:
            raise ConvergenceError("branch", branch.scene, "leads to an equilibrium that its regulator cannot take up within the limit", "allow more")
        nodes, period = _nearer(rows[-1], times[-1], x_end, slow)
        rows.append(_multiple(equations, nodes, period, times))
    states = np.array(rows)
    return Ladder(states, np.array(times), _energies(system, states), x_end, signs)


def finer(system: System, equations: Equations, found: Ladder, parts: NDArray[np.int_]) -> Ladder:
    """The same with orbits in between, so many parts from each orbit to the next (orbits - 1,).

    Raises:
        ConvergenceError: Orbits in between were not found.
    """
    rows, times = [found.states[0]], [float(found.periods[0])]
    for k, count in enumerate(parts.tolist()):
        (low, high), (before, after) = found.states[k : k + 2], found.periods[k : k + 2]
        held = int(np.argmax(np.abs(high[0] - low[0])))
        for share in np.arange(1, count) / count:
            nodes = (1 - share) * low[::FINE] + share * high[::FINE]
            rows.append(_multiple(equations, nodes, float((1 - share) * before + share * after), times, held))
        rows.append(high)
        times.append(float(after))
    states = np.array(rows)
    return Ladder(states, np.array(times), _energies(system, states), found.target, found.signs)


def _energies(system: System, quarters: Vector) -> Vector:
    """Energies of orbits by their states (orbits, m, nx), J above the hanging chain."""
    half = system.nq
    kinetic, potential = system.energy(quarters[:, 0, :half], quarters[:, 0, half:])
    _, hanging = system.energy(np.zeros(half), np.zeros(half))
    return np.asarray(kinetic + potential - hanging)


def _absolute(system: System, q: Vector) -> Vector:
    """Angles of the links from the hanging vertical."""
    back = np.array([scene_angles(system, row) for row in np.eye(system.links)]).T
    return np.asarray(np.linalg.solve(back, q))


def _quarters(equations: Equations, brakes: Vector, periods: Vector) -> Vector:
    """States along the quarters of many orbits, from their brakes."""
    x = np.concatenate([brakes, np.zeros_like(brakes)], axis=1)
    count = SEGMENTS * FINE
    kept, h = [x], periods / 4 / count / STEPS
    for _ in range(count):
        for _ in range(STEPS):
            x = equations.step(x, h)
        kept.append(x)
    return np.stack(kept, axis=1)


def _slowest(equations: Equations, x: Vector) -> float:
    """The slowest rate at which the chain leaves the equilibrium."""
    values = np.linalg.eigvals(equations.slopes(x[None])[0][0]).real
    return float(np.min(values[values > 1e-6]))


def _nearer(states: Vector, period: float, x_end: Vector, slow: float) -> tuple[Vector, float]:
    """A guess at nodes (SEGMENTS + 1, nx) and period of the orbit whose brake is nearer by a factor."""
    half = states.shape[1] // 2
    path = CubicSpline(np.linspace(0, period / 4, len(states)), states)
    stay = np.log(1 / NEARER) / slow
    after = period + 4 * stay
    away = NEARER * (states[0, :half] - x_end[:half])
    nodes = []
    for t in np.linspace(0, after / 4, SEGMENTS + 1):
        leaving = np.concatenate([x_end[:half] + away * np.cosh(slow * t), away * slow * np.sinh(slow * t)])
        share = float(np.clip((t - stay) / stay, 0, 1))
        nodes.append(share * path(max(t - stay, 0)) + (1 - share) * leaving)
    return np.array(nodes), after


def _multiple(equations: Equations, nodes: Vector, period: float, times: list[float], held: int = 0) -> Vector:
    """The orbit of a brake one of whose angles is given, by Newton; its states, its period added to `times`.

    Raises:
        ConvergenceError: It was not found.
    """
    nx = nodes.shape[1]
    half, m = nx // 2, len(nodes) - 1
    nodes[0, half:] = 0
    nodes[m, :half] = 0
    free = [k for k in range(half) if k != held]
    size = (half - 1) + nx * (m - 1) + half + 1
    for _ in range(25):
        ends, D = equations.carried(nodes[:-1], np.full(m, period / 4 / m), FINE * STEPS)
        miss = ends - nodes[1:]
        J = np.zeros((m * nx, size))
        J[:, -1] = (equations.rate(ends) / 4 / m).ravel()
        J[:nx, : half - 1] = D[0][:, free]
        for i in range(1, m):
            at = slice(half - 1 + nx * (i - 1), half - 1 + nx * i)
            J[nx * i : nx * (i + 1), at] = D[i, :, :nx]
            J[nx * (i - 1) : nx * i, at] = -np.eye(nx)
        J[nx * m - half :, -1 - half : -1] = -np.eye(half)
        change = np.linalg.solve(J, -miss.ravel())
        nodes[0, free] += change[: half - 1]
        nodes[1:m] += change[half - 1 : half - 1 + nx * (m - 1)].reshape(m - 1, nx)
        nodes[m, half:] += change[-1 - half : -1]
        period += float(change[-1])
        if np.max(np.abs(change)) < CLOSED:
            times.append(period)
            return _between(equations, nodes, period)
    raise ConvergenceError("branch", f"{period:.6g} s", "is a period beyond the branch at which no orbit was found", "trace the family further")


def _between(equations: Equations, nodes: Vector, period: float) -> Vector:
    """States along the quarter, each part from its own node."""
    x, h = nodes[:-1].copy(), np.full(len(nodes) - 1, period / 4 / (len(nodes) - 1) / FINE / STEPS)
    kept = []
    for _ in range(FINE):
        kept.append(x)
        for _ in range(STEPS):
            x = equations.step(x, h)
    return np.concatenate([np.stack(kept, axis=1).reshape(-1, nodes.shape[1]), nodes[-1:]])
