"""Where a climb's target is taken up: starts on the ellipsoid against an integrator of their own, and one that the linear ellipsoid takes for its own."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from phichain import build
from phichain.control import Gains
from phichain.errors import ControlError
from phichain.laws import GainTable
from phichain.laws.family import LEAVE
from phichain.orbits.climb.across import asked_between
from phichain.orbits.climb.catch import narrowed, regulators
from phichain.orbits.climb.design import NEEDED, gravity_torque
from phichain.orbits.climb.motion import Equations
from phichain.scene.library import find_scene
from phichain.trials.climb import driven_at

G, M, L, R = 9.81, 0.5, 0.5, 0.25
WEIGHTS = np.array([1.0, 1.0, 0.05, 0.05])
SHARE = 0.2


@pytest.fixture(scope="module")
def elbow() -> tuple[Equations, Gains, GainTable]:
    """Joint 2 at a fifth of its gravity torque, by the dearest input."""
    system = build(replace(driven_at(find_scene("planar2"), 2), want=NEEDED))
    torque = gravity_torque(system, 2)
    return (Equations(system), *regulators(system, (-1, -1), WEIGHTS, torque, SHARE * torque, 1e-3)[-1])


def farthest(table: GainTable, start: np.ndarray, W: np.ndarray) -> tuple[float, float]:
    """Largest and last level |W z|^2 of two point masses at the rods' middles, from the textbook, the clipped law called all the time."""
    K, high, target = np.array(table.gains[0])[0], table.high[0], np.array(table.targets[0])

    def rate(t: float, z: np.ndarray) -> np.ndarray:
        x, u = target + z, float(np.clip(-K @ z, -high, high))
        a, b, wa, wb = x[0], x[0] + x[1], x[2], x[2] + x[3]
        s, c = M * L * R * np.sin(a - b), M * L * R * np.cos(a - b)
        mass = np.array([[M * R**2 + M * L**2, c], [c, M * R**2]])
        force = np.array([-s * wb**2 - G * M * (R + L) * np.sin(a) - u, s * wa**2 - G * M * R * np.sin(b) + u])
        acc = np.linalg.solve(mass, force)
        return np.array([wa, wb - wa, acc[0], acc[1] - acc[0]])

    way = solve_ivp(rate, (0, 2.5), start, rtol=1e-8, atol=1e-10, max_step=0.02)
    levels = np.sum((W @ way.y) ** 2, axis=0)
    return float(np.max(levels)), float(levels[-1])


def test_every_end_of_the_ellipsoid_comes_home_where_the_linear_one_is_left(elbow: tuple[Equations, Gains, GainTable]) -> None:
    """Along the stable directions the linear ellipsoid reaches a quarter of a radian, a thousand times as far as across."""
    equations, gains, table = elbow
    W, linear = narrowed(equations, gains, table, WEIGHTS), np.array(table.shapes[0])

    def ends(shape: np.ndarray) -> np.ndarray:
        sizes, axes = np.linalg.eigh(shape.T @ shape)
        a, b = axes[:, 0] / np.sqrt(sizes[0]), axes[:, 1] / np.sqrt(sizes[1])
        return np.array([np.cos(angle) * a + np.sin(angle) * b for angle in np.linspace(0, np.pi, 4)[:-1]])

    for start in ends(W):
        largest, last = farthest(table, start, W)
        assert largest < LEAVE / 2 and last < 0.05
    assert max(farthest(table, start, linear)[0] for start in ends(linear)) > LEAVE
    # Narrower along, and as thick across.
    thin, narrow = np.linalg.svd(linear)[1], np.linalg.svd(W)[1]
    assert narrow[-1] > 1.2 * thin[-1] and narrow[0] < 1.05 * thin[0]


def test_a_law_that_brings_nothing_home_takes_nothing_up(elbow: tuple[Equations, Gains, GainTable]) -> None:
    equations, gains, table = elbow
    with pytest.raises(ControlError, match="from nowhere near"):
        narrowed(equations, gains, replace(table, low=(-1e-9,), high=(1e-9,)), WEIGHTS)


def test_what_a_law_asks_for_between_nodes_is_what_the_cubic_misses() -> None:
    """Of a mirrored sine by Catmull and Rom's cubic in Hermite's form, at its worst place."""
    nodes, k = 49, 3.0
    phase = np.linspace(0, np.pi, nodes)
    states = np.stack([np.cos(phase), np.cos(3 * phase)], axis=1)[None]
    gains = np.broadcast_to(np.array([0.0, k]), states.shape)
    x = np.cos(3 * np.concatenate([[phase[0] - phase[1]], phase, [phase[-1] + phase[1]]]))
    g, h = np.linspace(0, 1, 201)[:, None], phase[1]
    slopes = (x[2:] - x[:-2]) / 2
    cubic = (1 + 2 * g) * (1 - g) ** 2 * x[1:-2] + g * (1 - g) ** 2 * slopes[:-1] + g**2 * (3 - 2 * g) * x[2:-1] + g**2 * (g - 1) * slopes[1:]
    missed = k * np.max(np.abs(cubic - np.cos(3 * (phase[:-1] + g * h))), axis=0)
    assert np.max(asked_between(states, gains)) == pytest.approx(np.max(missed), rel=0.02)
