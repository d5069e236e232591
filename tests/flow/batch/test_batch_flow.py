"""Batch flows, trajectory by trajectory: the scalar flow to round-off, times, pieces and events of their own."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from phichain.errors import ArrayError, ToleranceError
from phichain.system.propagation import Stop
from tests.flow.batch.batches import CHAINS, flow, given, states
from tests.flow.flows import compiled, planar


@pytest.mark.parametrize("n", [1, 7, 8, 9, 33])
def test_every_trajectory_is_that_of_the_scalar_flow(n: int) -> None:
    chain = planar(2)
    q, v = states(chain, n)
    q *= 0.3
    found = flow(chain)(q, v, 0.0, 3.0, 1e-13)
    assert set(found.outcome) == {"done"} and np.all(found.t == 3.0)
    for k in range(n):
        alone = compiled(chain)(q[k], v[k], 0.0, 3.0, 1e-13)
        assert np.max(np.abs(found.q[k] - alone.q)) < 1e-12
        assert abs(int(found.steps[k]) - alone.steps) <= 2


@pytest.mark.long
@pytest.mark.parametrize("name", [*CHAINS, "portable"])
def test_every_kind_of_chain(name: str) -> None:
    chain = CHAINS["unrolled" if name == "portable" else name]
    q, v, *u = states(chain, 9)
    q[:] = q if not chain.is_planar else 0.2 * q
    single, inputs = chain.real == "float", {"u": 0.1 * u[0]} if u else {}
    t_end, tol = (0.005 if chain.links > 9 else 0.3), 1e-5 if single else 1e-13
    found = flow(chain, portable=name == "portable")(q, v, 0.0, t_end, tol, **inputs, **given(chain))
    for k in range(9):
        own = {name: value[k] for name, value in inputs.items()}
        alone = compiled(chain)(q[k], v[k], 0.0, t_end, tol, **own, **given(chain))
        assert found.outcome[k] == alone.outcome == "done"
        assert np.max(np.abs(found.q[k] - alone.q)) < (1e-4 if single else 1e-11)


def test_rows_of_the_configuration_make_the_steps_of_one_trajectory() -> None:
    """In space, at an order that both forms have: sizes of the last terms and slopes at ends of steps are those of the state's rows."""
    chain = CHAINS["spatial"]
    q, v, *u = states(chain, 3)
    inputs = {"u": 0.1 * u[0]} if u else {}
    found = flow(chain)(q, v, 0.0, 0.3, 1e-15, **inputs, **given(chain))
    for k in range(3):
        own = {name: value[k] for name, value in inputs.items()}
        alone = compiled(chain)(q[k], v[k], 0.0, 0.3, 1e-15, **own, **given(chain))
        assert found.order == alone.order and abs(int(found.steps[k]) - alone.steps) <= 1
        assert np.max(np.abs(found.q[k] - alone.q)) < 1e-14 and np.max(np.abs(found.v[k] - alone.v)) < 1e-12


def test_equal_trajectories_end_equal_wherever_they_run() -> None:
    found = flow(planar(2))(np.tile([0.4, 0.0], (21, 1)), np.zeros((21, 2)), 0.0, 5.0, 1e-12)
    assert len(set(map(tuple, found.q))) == 1 and len(set(found.steps)) == 1


def test_times_on_the_way_and_times_of_ones_own() -> None:
    """Starts and ends differ, one goes backwards; what a trajectory does not reach stays NaN."""
    chain = planar(2)
    q, v = states(chain, 11)
    end = np.linspace(1.0, 2.0, 11)
    times = [0.25, 0.5, 1.0]
    found = flow(chain)(q, v, 0.0, end, 1e-13, times=times)
    assert found.q_at.shape == (11, 3, 2) and np.all(found.written == 3)
    alone = compiled(chain)(q[4], v[4], 0.0, float(end[4]), 1e-13, times=times)
    assert np.max(np.abs(found[4].q_at - alone.q_at)) < 1e-11
    back = flow(chain)(found.q, found.v, end, 0.0, 1e-13, lost=found.lost)
    assert np.max(np.abs(back.q - q)) < 1e-9
    short = flow(chain)(q, v, 0.0, 2.0, 1e-13, times=times, max_steps=3)
    assert (
        set(short.outcome) == {"step budget"}
        and np.all(short.steps == 3)
        and np.isnan(short.q_at[:, 2]).all()
    )


def test_pieces_are_the_whole_to_the_last_bit() -> None:
    chain, go = planar(2), flow(planar(2))
    q, v = states(chain, 10)
    whole = go(q, v, 0.0, 2.0, 1e-12)
    t, lost, steps = np.zeros(10), None, np.zeros(10, int)
    while not np.all(t == 2.0):
        part = go(q, v, t, 2.0, 1e-12, max_steps=7, lost=lost)
        q, v, t, lost, steps = part.q, part.v, part.t, part.lost, steps + part.steps
    assert np.array_equal(q, whole.q) and np.array_equal(v, whole.v) and np.array_equal(steps, whole.steps)


@pytest.mark.parametrize("stop", [Stop("q", 0), Stop("v", 1, direction=-1), Stop("depth", 1, value=0.6)])
def test_each_trajectory_stops_where_it_meets_the_event(stop: Stop) -> None:
    chain = planar(2)
    q = np.column_stack([np.linspace(0.3, 1.0, 10), np.zeros(10)])
    found = flow(chain)(q, np.zeros_like(q), 0.0, 1.5, 1e-14, stop=stop)
    assert "event" in found.outcome
    for k in range(10):
        alone = compiled(chain)(q[k], np.zeros(2), 0.0, 1.5, 1e-14, stop=stop)
        assert found.outcome[k] == alone.outcome and abs(found.t[k] - alone.t) < 1e-12


def test_one_that_overflows_does_not_disturb_the_others() -> None:
    chain = planar(2)
    q, v = states(chain, 12)
    clean = flow(chain)(q, v, 0.0, 1.0, 1e-12)
    v[5] = [1e200, -1e200]
    found = flow(chain)(q, v, 0.0, 1.0, 1e-12)
    assert found.outcome[5] == "not finite" and found.t[5] == 0.0 and found.v[5, 0] == 1e200
    rest = np.arange(12) != 5
    assert np.array_equal(found.q[rest], clean.q[rest])


@pytest.mark.parametrize(
    ("change", "error", "field"),
    [
        ({"q": [0.1, 0.2]}, ArrayError, "q"),
        ({"v": [[0.0, np.nan]]}, ArrayError, "v"),
        ({"t_end": [1.0, 2.0]}, ArrayError, "t_end"),
        ({"t": np.inf}, ArrayError, "propagate_batch.t"),
        ({"times": [0.5, 0.2]}, ArrayError, "times"),
        ({"tol": -1.0}, ToleranceError, "tol"),
        ({"stop": Stop("v", 2)}, ArrayError, "stop.index"),
        ({"lost": np.zeros((1, 4))}, ArrayError, "lost"),
        ({"lost": np.full((1, 5), -1e300)}, ArrayError, "is no rounding of t"),
    ],
)
def test_bad_input_is_refused(change: dict[str, Any], error: type[Exception], field: str) -> None:
    arguments: dict[str, Any] = {"q": [[0.1, 0.2]], "v": [[0, 0]], "t": 0.0, "t_end": 1.0, "tol": 1e-9}
    with pytest.raises(error, match=field):
        flow(planar(2))(**(arguments | change))
