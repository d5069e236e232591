"""A shaken pivot and a stepper's cart: flows under held accelerations, against Lagrangians by hand in twenty digits."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache
from typing import Any

import numpy as np
import pytest
from mpmath import cos, mp, mpf, sin

from phichain import build, simulate
from phichain.scene import Scene
from phichain.system import System

FLOWS = ("propagate", "propagate_batch", "propagate_stiff")
WANT = ["forward_dynamics", "state_jacobian", *FLOWS, "step"]
LENGTH, GRAVITY = 0.3, 9.81
SHAKEN = Scene("shaken", 1, base="moving", mass=0.2, length=LENGTH, want=WANT, variational=True)
MASS, LENGTHS, COM = (0.4, 0.3), (0.5, 0.45), (0.2, 0.25)
STEPPER = Scene(
    "stepper", 2, base="cart", drive="acceleration", mass=MASS, length=LENGTHS, com=COM, angles="absolute", want=WANT,
    variational=True,
)  # fmt: skip
SPAN = 0.05
"""Length of a segment of constant acceleration, s."""
SHARES = 4
"""Steps of the reference a segment."""


def shaken(state: Sequence[Any], b: Sequence[float]) -> list[Any]:
    """Kapitza's pendulum, the pivot moved by b: l theta'' = -(g - b_2) sin theta - b_1 cos theta."""
    theta, rate = state
    return [rate, (-(mpf(GRAVITY) - b[1]) * sin(theta) - b[0] * cos(theta)) / mpf(LENGTH)]


def stepper(state: Sequence[Any], b: Sequence[float]) -> list[Any]:
    """Two links under a cart with x'' = b, by Lagrange's equations in absolute angles."""
    _, one, two, speed, w1, w2 = state
    (m1, m2), (l1, _), (r1, r2) = (map(mpf, values) for values in (MASS, LENGTHS, COM))
    c11, c22, c12 = m1 * r1**2 + m2 * l1**2, m2 * r2**2, m2 * l1 * r2 * cos(one - two)
    s12, mu1, mu2 = m2 * l1 * r2 * sin(one - two), m1 * r1 + m2 * l1, m2 * r2
    first = -s12 * w2**2 - mu1 * (GRAVITY * sin(one) + b[0] * cos(one))
    second = s12 * w1**2 - mu2 * (GRAVITY * sin(two) + b[0] * cos(two))
    whole = c11 * c22 - c12**2
    return [speed, w1, w2, mpf(b[0]), (c22 * first - c12 * second) / whole, (c11 * second - c12 * first) / whole]


@cache
def exact(run: str, first: int = 0, last: int | None = None) -> np.ndarray:
    """The state after all of some segments, by Gragg's midpoint rule extrapolated in 30 digits until it stands still."""
    _, field, start, inputs = RUNS[run]
    with mp.workdps(30):
        state = [mpf(x) for x in start]
        for b in (b for b in inputs[first:last] for _ in range(SHARES)):
            state = extrapolated(lambda y, b=b: field(y, b), state)
        return np.array(state, float)


def extrapolated(slope: Callable[[list[Any]], list[Any]], start: list[Any]) -> list[Any]:
    row: list[list[Any]] = []
    for k, count in enumerate(range(2, 32, 2)):
        h = mpf(SPAN) / (SHARES * count)
        before, now = start, moved(start, slope(start), h)
        for _ in range(count - 1):
            before, now = now, moved(before, slope(now), 2 * h)
        new = [now]
        for j, last in enumerate(row):
            ratio = (mpf(count) / (2 * (k - j))) ** 2
            new.append([x + (x - y) / (ratio - 1) for x, y in zip(new[-1], last, strict=True)])
        if row and max(abs(x - y) for x, y in zip(new[-1], row[-1], strict=True)) < 1e-15 * max(map(abs, new[-1])):
            return new[-1]
        row = new
    raise AssertionError("the reference does not settle")


def moved(state: list[Any], rate: list[Any], h: Any) -> list[Any]:
    return [x + h * y for x, y in zip(state, rate, strict=True)]


KAPITZA = [[0.0, 150.0 * float(np.cos(40 * SPAN * k))] for k in range(12)]
"""Up and down, far beyond g; the pendulum starts beside its upper rest."""
ASIDE = [[4.0 * (-1) ** k, -3.0 + k] for k in range(12)]
STEPS = [[6.0 * (-1) ** (k // 3)] for k in range(12)]
RUNS = {
    "kapitza": (SHAKEN, shaken, [3.0, 0.4], KAPITZA),
    "both ways": (SHAKEN, shaken, [0.3, -1.0], ASIDE),
    "stepper": (STEPPER, stepper, [0.1, 0.4, 0.9, -0.2, 1.0, 0.3], STEPS),
}
BUILT: dict[str, System] = {}


def system(scene: Scene) -> System:
    if scene.name not in BUILT:
        BUILT[scene.name] = build(scene)
    return BUILT[scene.name]


def flown(of: System, flow: str, start: Sequence[float], inputs: Sequence[Sequence[float]], tol: float = 1e-15) -> np.ndarray:
    """The state after all segments by one of the flows; a batch carries the motion twice."""
    q, v = np.array(start[: of.nq]), np.array(start[of.nq :])
    lanes = 2 if flow == "propagate_batch" else 1
    if lanes > 1:
        q, v = np.tile(q, (2, 1)), np.tile(v, (2, 1))
    for b in inputs:
        end = of.function(flow)(q, v, 0.0, SPAN, tol, u=np.array(b))
        q, v = end.q, end.v
    return np.concatenate([q[-1], v[-1]] if lanes > 1 else [q, v])


@pytest.mark.long
@pytest.mark.parametrize("flow", FLOWS)
@pytest.mark.parametrize("run", RUNS)
def test_motion_over_segments_of_constant_acceleration(run: str, flow: str) -> None:
    scene, _, start, inputs = RUNS[run]
    true = exact(run)
    found = flown(system(scene), flow, start, inputs, 1e-13 if flow == "propagate_stiff" else 1e-15)
    assert np.max(np.abs(found - true)) < (1e-9 if flow == "propagate_stiff" else 1e-11) * np.max(np.abs(true))


@pytest.mark.parametrize("run", RUNS)
def test_columns_are_derivatives_of_the_flow(run: str) -> None:
    scene, _, start, inputs = RUNS[run]
    of, size = system(scene), len(start)
    q, v, matrix = np.array(start[: of.nq]), np.array(start[of.nq :]), np.eye(size)
    for b in inputs[:3]:
        end = of.propagate(q, v, 0.0, SPAN, 1e-15, u=np.array(b), transition=matrix)
        q, v, matrix = end.q, end.v, end.transition
    width = 1e-6
    for i in range(size):
        ends = [flown(of, "propagate", np.array(start) + way * width * np.eye(size)[i], inputs[:3]) for way in (1, -1)]
        slope = (ends[0] - ends[1]) / (2 * width)
        assert np.max(np.abs(matrix[:, i] - slope)) < 1e-7 * np.max(np.abs(matrix))


@pytest.mark.parametrize("run", RUNS)
def test_simulate_and_steps_follow(run: str) -> None:
    """One segment by SciPy on the emitted right side, and by Runge-Kutta steps whose error falls by sixteen."""
    scene, _, start, inputs = RUNS[run]
    of, true = system(scene), exact(run, 1, 2)
    motion = simulate(of, start, SPAN, u=inputs[1], method="DOP853", tol=1e-12)
    assert np.max(np.abs(np.concatenate([motion.q[-1], motion.v[-1]]) - true)) < 1e-10 * np.max(np.abs(true))
    gaps = []
    for count in (8, 16):
        q, v = np.array(start[: of.nq]), np.array(start[of.nq :])
        for _ in range(count):
            q, v = of.step(SPAN / count, q, v, np.array(inputs[1]))
        gaps.append(np.max(np.abs(np.concatenate([q, v]) - true)))
    assert 12 < gaps[0] / gaps[1] < 20


def test_a_cart_that_is_told_moves_as_told() -> None:
    of = system(STEPPER)
    end = of.propagate([0.3, 0.1, -0.2], [0.5, 0.0, 0.0], 0.0, 0.4, 1e-15, u=[-2.0])
    assert end.q[0] == pytest.approx(0.3 + 0.5 * 0.4 - 0.4**2, abs=1e-15)
    assert end.v[0] == pytest.approx(0.5 - 0.8, abs=1e-15)
