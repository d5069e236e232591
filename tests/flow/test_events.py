"""Events of the flow, one trajectory and many: pairs of crossings between two looks, directions, touches, ends of steps.

The times are known without the flow: a link without gravity turns at its rate, a pendulum's energy gives its angle of rest,
and a pair of crossings is refined from dense output that no event takes part in.
"""

from __future__ import annotations

import math
from functools import cache
from itertools import product
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from phichain.scene import Scene
from phichain.system.propagation import Propagation, Stop
from tests.flow.batch.batches import flow
from tests.flow.flows import compiled, planar, scene

Vector = NDArray[np.float64]
AFLOAT = scene("afloat", "planar", "fixed", links=1, mass=1, length=1, gravity=0)
SWING = scene("swing", "planar", "fixed", links=1, mass=1, length=1, gravity=9.81)
SPHERE = scene("sphere", "spatial", "fixed", links=1, mass=1, length=1, gravity=9.81)
PAIR = planar(2)
TOL = 1e-13


def one(chain: Scene, q: Any, v: Any, t: float, t_end: float, **more: Any) -> Propagation:
    return compiled(chain)(q, v, t, t_end, TOL, **more)


def many(chain: Scene, q: Any, v: Any, t: float, t_end: float, **more: Any) -> Propagation:
    """The last of eleven equal trajectories: more than a vector has lanes."""
    rows = {name: value if name == "stop" else np.tile(value, (11, 1)) for name, value in more.items()}
    found = flow(chain)(np.tile(q, (11, 1)), np.tile(v, (11, 1)), t, t_end, TOL, **rows)
    assert len(set(found.t.tolist())) == 1 and len(set(found.outcome)) == 1
    return found[10]


FORMS = pytest.mark.parametrize("go", [one, many], ids=["one", "many"])


def top(chain: Scene, q: Any, v: Any, t_end: float, value: Any) -> tuple[float, float]:
    """(time, height) of the first maximum of value(q, v), from dense output: three times closer and closer around it."""
    low, high = 0.0, t_end
    for _ in range(3):
        times = np.linspace(low, high, 401)
        run = one(chain, q, v, 0.0, t_end, times=times)
        heights = np.array([value(a, b) for a, b in zip(run.q_at, run.v_at, strict=True)])
        k = int(np.argmax(heights))
        low, high = times[max(k - 1, 0)], times[min(k + 1, 400)]
    return float(times[k]), float(heights[k])


GRAZING = {
    "q": (SWING, [0.5], [1.0], lambda q, v: q[0], Stop("q", 0)),
    "v": (SWING, [-0.3], [1.5], lambda q, v: v[0], Stop("v", 0)),
    "depth": (SWING, [0.4], [-2.0], lambda q, v: math.cos(q[0]), Stop("depth", 0)),
    "depth of two": (PAIR, [0.4, 0.3], [-2.0, -1.5], lambda q, v: 0.5 * math.cos(q[0]) + 0.25 * math.cos(q[0] + q[1]), Stop("depth", 1)),
    "unit vector": (SPHERE, [0.6, 0.0, 0.8], [0.3, 2.0, -0.225], lambda q, v: q[0], Stop("q", 0)),
    "depth on the sphere": (SPHERE, [0.6, 0.0, 0.8], [0.0, -2.0, 0.0], lambda q, v: abs(q[2]), Stop("depth", 0)),
}  # fmt: skip


@FORMS
@pytest.mark.parametrize("kind", GRAZING)
@pytest.mark.parametrize("below", [1e-3, 1e-6])
def test_two_crossings_between_two_looks_are_found(kind: str, below: float, go: Any) -> None:
    """Just below a maximum a scalar rises through a value and falls through it again, in far less than a step.

    Around the maximum at t_m the two are t_m +- sqrt(2 below / curvature): first and second are as far from it.
    """
    chain, q, v, value, stop = GRAZING[kind]
    t_end = 0.35
    at, height = top(chain, q, v, t_end, value)
    assert 0.02 < at < t_end - 0.02
    found = {}
    for direction in (1, 0, -1):
        event = Stop(stop.scalar, stop.index, height - below, direction)
        run = go(chain, q, v, 0.0, t_end, stop=event)
        assert run.outcome == "event"
        assert abs(value(run.q, run.v) - event.value) < 1e-13
        found[direction] = run.t
    assert found[0] == found[1]
    first, second = at - found[1], found[-1] - at
    assert 0 < first < 0.1 and abs(second / first - 1) < 30 * math.sqrt(below) + 1e-3


@FORMS
@pytest.mark.parametrize("kind", GRAZING)
def test_what_stays_below_is_no_event(kind: str, go: Any) -> None:
    chain, q, v, value, stop = GRAZING[kind]
    _, height = top(chain, q, v, 0.35, value)
    for direction in (-1, 0, 1):
        run = go(chain, q, v, 0.0, 0.35, stop=Stop(stop.scalar, stop.index, height + 1e-9, direction))
        assert run.outcome == "done" and run.t == 0.35


@FORMS
def test_a_pair_is_found_backwards_with_the_directions_of_its_way(go: Any) -> None:
    """Backwards in time the crossing that comes later is met first; it rises along that way."""
    chain, q, v, value, _ = GRAZING["q"]
    at, height = top(chain, q, v, 0.35, value)
    end = one(chain, q, v, 0.0, 0.35)
    rising, falling = (
        go(chain, end.q, end.v, 0.35, 0.0, stop=Stop("q", 0, height - 1e-4, direction))
        for direction in (1, -1)
    )
    assert rising.outcome == falling.outcome == "event"
    assert falling.t < at < rising.t
    forwards = go(chain, q, v, 0.0, 0.35, stop=Stop("q", 0, height - 1e-4, 1))
    assert abs(forwards.t - falling.t) < 1e-10


@FORMS
def test_a_touch_from_where_it_stands_is_no_event(go: Any) -> None:
    """Released from rest, a pendulum's rate is zero at its start and after half a period: the start is none."""
    run = go(SWING, [0.3], [0.0], 0.0, 1.5, stop=Stop("v", 0))
    half = math.pi / float(_agm(1.0, math.cos(0.15))) * math.sqrt(1 / 9.81)
    assert run.outcome == "event" and abs(run.t - half) < 1e-13


def _agm(a: float, b: float) -> float:
    for _ in range(8):
        a, b = (a + b) / 2, math.sqrt(a * b)
    return a


@FORMS
def test_at_the_end_of_the_way_an_event_is_met_once(go: Any) -> None:
    """A link without gravity: q = 0.5 + 0.25 t, all sums exact. At t_end it stops, and does not stop again there."""
    stop = Stop("q", 0, 1.0)
    met = go(AFLOAT, [0.5], [0.25], 0.0, 2.0, stop=stop)
    assert (met.outcome, met.t, met.q[0]) == ("event", 2.0, 1.0)
    on = go(AFLOAT, met.q, met.v, met.t, 4.0, stop=stop, lost=met.lost)
    assert (on.outcome, on.t, on.q[0]) == ("done", 4.0, 1.5)
    short = go(AFLOAT, [0.5], [0.25], 0.0, 1.75, stop=stop)
    assert short.outcome == "done"
    assert go(AFLOAT, short.q, short.v, 1.75, 4.0, stop=stop, lost=short.lost).t == 2.0


@FORMS
def test_the_second_of_a_pair_is_met_from_the_first(go: Any) -> None:
    """The run goes on from a scalar of zero, which rises and falls again within the first look."""
    for kind in ("q", "depth", "unit vector"):
        chain, q, v, value, stop = GRAZING[kind]
        at, height = top(chain, q, v, 0.35, value)
        event = Stop(stop.scalar, stop.index, height - 1e-5)
        first = go(chain, q, v, 0.0, 0.35, stop=event)
        second = go(chain, first.q, first.v, first.t, 0.35, stop=event, lost=first.lost)
        assert first.outcome == second.outcome == "event" and first.t < at < second.t
        assert abs((second.t - at) / (at - first.t) - 1) < 0.1
        third = go(chain, second.q, second.v, second.t, 0.35, stop=event, lost=second.lost)
        assert third.outcome == "done"


@FORMS
@pytest.mark.parametrize("direction", [-1, 0, 1])
def test_at_the_ends_of_steps_crossings_are_neither_lost_nor_met_twice(direction: int, go: Any) -> None:
    """The values are the ones that the scalar has, to the last bit, at the ends of its own steps."""
    q, v, t_end = [0.4, 0.0], [0.0, 0.0], 3.0
    run = one(PAIR, q, v, 0.0, t_end, own=60)
    for k in range(4, len(run.t_at) - 1, 5):
        value = float(run.q_at[k, 1])
        signs = np.sign(np.delete(_fine(t_end), 0) - value)
        signs = signs[signs != 0]
        expected = np.count_nonzero(np.diff(signs) * (direction or np.diff(signs)) > 0)
        met, state, lost, t = 0, (np.array(q), np.array(v)), None, 0.0
        while t < t_end:
            part = go(
                PAIR,
                *state,
                t,
                t_end,
                stop=Stop("q", 1, value, direction),
                **({} if lost is None else {"lost": lost}),
            )
            state, lost, t = (part.q, part.v), part.lost, part.t
            met += part.outcome == "event"
        assert met == expected, (k, value)


@pytest.mark.parametrize("links", [1, 2])
def test_unit_vectors_meet_every_crossing_once(links: int) -> None:
    """What keeps them unit vectors moves the last bits of a state at which a run stopped."""
    chain = scene(f"spheres{links}", "spatial", "fixed", links=links, mass=0.1, length=0.1)
    random = np.random.default_rng(3)
    q, v = (random.normal(size=(links, 3)) for _ in range(2))
    q /= np.linalg.norm(q, axis=1)[:, None]
    v -= np.sum(q * v, axis=1)[:, None] * q
    fine = one(chain, q.ravel(), v.ravel(), 0.0, 2.0, times=np.linspace(0, 2, 4001)[1:])
    depth = 0.1 * fine.q_at[:, 2]
    seen = (
        [("q", i, fine.q_at[:, i]) for i in range(3)]
        + [("v", i, fine.v_at[:, i]) for i in range(3)]
        + [("depth", 0, depth)]
    )
    moving = [
        row for row in seen if np.ptp(row[2]) > 1e-6
    ]  # a spherical pendulum keeps its vertical momentum
    assert len(moving) >= 6
    for (kind, index, signal), share in product(moving, random.uniform(0.1, 0.9, 3)):
        value = float(np.min(signal) + share * np.ptp(signal))
        expected = np.count_nonzero(np.diff(np.sign(signal - value)))
        met, state, t = 0, (q.ravel(), v.ravel()), 0.0
        more: dict[str, Any] = {}
        while t < 2.0:
            part = one(chain, *state, t, 2.0, stop=Stop(kind, index, value), **more)
            state, more, t = (part.q, part.v), {"lost": part.lost}, part.t
            met += part.outcome == "event"
        assert met == expected, (kind, index, value)


@cache
def _fine(t_end: float) -> Vector:
    return one(PAIR, [0.4, 0.0], [0.0, 0.0], 0.0, t_end, times=np.linspace(0, t_end, 4001)).q_at[:, 1]
