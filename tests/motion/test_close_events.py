"""Pairs of crossings that lie between two looks at an event, down to those of a scalar that barely passes zero."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.special import ellipk

from phichain import build
from phichain.motion import Event, simulate
from phichain.motion.events import Watch
from phichain.scene import Scene
from tests.motion.simulate.test_simulate_methods import OMEGA_0, pendulum

QUARTER = ellipk(np.sin(1.0) ** 2) / OMEGA_0


def watched(event: Event, knots: np.ndarray) -> list[float]:
    """The crossings of a scalar of time alone, which stands for the state."""

    def clock(t: float) -> np.ndarray:
        return np.array([t])

    _, found, _ = Watch.start((event,), knots[0], clock(knots[0])).advance(clock, knots.tolist())
    return [crossing.t for crossing in found]


@pytest.mark.parametrize("depth", [1e-2, 1e-5, 1e-8, 1e-12, 1e-14])
@pytest.mark.parametrize("way", [1, -1])
@pytest.mark.parametrize("side", [1, -1])
def test_a_scalar_that_barely_passes_zero_crosses_it_twice(depth: float, way: int, side: int) -> None:
    """cos(t) - (1 - d) about t = 2 pi, from 1 - d on, wherever the top lies between the looks, forwards and backwards."""
    half = np.arccos(1 - depth)
    for shift in np.linspace(0.003, 0.097, 20):
        knots = 2 * np.pi + way * (np.arange(-5, 6) * 0.1 + shift)
        found = watched(Event("top", lambda t, x: side * (np.cos(x[0]) - (1 - depth))), knots)
        expected = 2 * np.pi + way * half * np.array([-1, 1])
        assert np.allclose(found, expected, rtol=0, atol=1e-6 * half + 1e-14 / half), shift


@pytest.mark.parametrize(("direction", "index"), [(1, 0), (-1, 1)])
def test_each_of_a_pair_has_its_direction(direction: int, index: int) -> None:
    found = watched(Event("top", lambda t, x: np.cos(x[0]) - (1 - 1e-8), direction), np.linspace(6.0, 6.5, 6))
    assert np.allclose(found, 2 * np.pi + np.arccos(1 - 1e-8) * (2 * index - 1), rtol=0, atol=1e-10)


def test_a_scalar_that_turns_before_zero_crosses_nothing_and_one_far_away_is_not_sought() -> None:
    looks = []

    def far(t: float, x: np.ndarray) -> float:
        looks.append(t)
        return float(np.cos(x[0]) - 3.0)

    knots = np.linspace(6.0, 6.5, 6)
    assert watched(Event("short", lambda t, x: np.cos(x[0]) - (1 + 1e-12)), knots) == []
    assert watched(Event("far", far), knots) == [] and len(looks) == 2 * len(knots)


def test_a_pair_ends_a_run_at_its_first() -> None:
    event = Event("top", lambda t, x: np.cos(x[0]) - (1 - 1e-8), terminal=True)
    clock = lambda t: np.array([t])
    knots = np.linspace(6.0, 6.5, 6).tolist()
    _, found, terminal = Watch.start((event,), 6.0, clock(6.0)).advance(clock, knots)
    assert terminal is found[-1] and len(found) == 1 and terminal.t < 2 * np.pi


@pytest.mark.parametrize("depth", [1e-4, 1e-8, 1e-10])
@pytest.mark.parametrize("method", ["auto", "DOP853"])
def test_a_pendulum_passes_an_angle_just_below_its_turn_twice(method: str, depth: float) -> None:
    """Released at 2 rad it is back after four quarters, and above 2 - d for sqrt(2 d / (omega_0^2 sin 2)) before and after."""
    event = Event("nearly back", lambda t, x: x[0] - (2.0 - depth))
    run = simulate(pendulum(), [2.0, 0.0], [0, 5 * QUARTER], method, 1e-13, events=event)
    half = np.sqrt(2 * depth / (OMEGA_0**2 * np.sin(2.0)))
    expected = [half, 4 * QUARTER - half, 4 * QUARTER + half]
    assert np.allclose([crossing.t for crossing in run.events], expected, rtol=0, atol=1e-2 * half)


def test_the_chaotic_chain_passes_just_below_its_turn_twice() -> None:
    """Two unit links from (120, -10) degrees: theta_2 is above its maximum less 1e-8 for 2 sqrt(2e-8 / |theta_2''|), 52 us."""
    scene = Scene("close_events", 2, mass=1.0, length=1.0, angles="absolute", want=["forward_dynamics", "propagate"])
    system, start = build(scene), (np.deg2rad([120.0, -10.0]), np.zeros(2))
    turn = simulate(system, start, [0, 5], tol=1e-14, events=Event("turn", lambda t, x: x[3], -1)).events[0]
    near = Event("near", lambda t, x: x[1] - (turn.x[1] - 1e-8))
    found = [crossing.t - turn.t for crossing in simulate(system, start, [0, turn.t + 0.5], tol=1e-14, events=near).events]
    half = np.sqrt(2e-8 / abs(system.forward_dynamics(turn.x[:2], turn.x[2:])[1]))
    assert np.allclose(found, [-half, half], rtol=1e-3, atol=0)
