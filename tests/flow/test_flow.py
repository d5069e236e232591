"""What the compiled Taylor flow can do: backwards, times on the way, pieces, stops; and what it refuses."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from phichain.errors import ArrayError, ToleranceError
from phichain.system.propagation import Stop
from tests.flow.extreme_cases import CASES, EPS, of_case
from tests.flow.flows import CHAINS, compiled, planar, scene


@pytest.mark.parametrize("name", CHAINS)
def test_there_and_back_again(name: str) -> None:
    chain, go = CHAINS[name], compiled(CHAINS[name])
    q, v = np.linspace(0.3, -0.2, chain.nq), np.linspace(-0.5, 0.4, chain.nv)
    u = {"u": np.linspace(0.1, 0.2, chain.nu)} if chain.nu else {}
    there = go(q, v, 1.0, 4.0, 1e-14, **u)
    back = go(there.q, there.v, 4.0, 1.0, 1e-14, **u)
    assert back.t == 1.0 and back.outcome == "done"
    assert np.max(np.abs(np.append(back.q - q, back.v - v))) < 1e-11


def test_states_on_the_way_are_those_of_shorter_runs() -> None:
    go, times = compiled(planar(2)), np.array([0.0, 0.013, 0.5, 0.5, 1.1, 2.0])
    whole = go([0.4, 0], [0, 0], 0.0, 2.0, 1e-14, times=times)
    for t, q, v in zip(times[1:], whole.q_at[1:], whole.v_at[1:], strict=True):
        short = go([0.4, 0], [0, 0], 0.0, float(t), 1e-14)
        assert np.max(np.abs(np.append(short.q - q, (short.v - v) / 20))) < 1e-13
    assert whole.q_at[0].tolist() == [0.4, 0.0]
    assert whole.q_at[-1].tolist() == whole.q.tolist()


def test_a_run_in_pieces_is_the_run_to_the_last_bit() -> None:
    go = compiled(planar(2))
    whole = go([0.4, 0], [0, 0], 0.0, 5.0, 1e-12)
    q, v, t, lost, steps = np.array([0.4, 0]), np.zeros(2), 0.0, None, 0
    while t != 5.0:
        part = go(q, v, t, 5.0, 1e-12, max_steps=7, lost=lost)
        assert part.outcome == ("done" if part.t == 5.0 else "step budget")
        q, v, t, lost, steps = part.q, part.v, part.t, part.lost, steps + part.steps
    assert (q.tolist(), v.tolist(), steps) == (whole.q.tolist(), whole.v.tolist(), whole.steps)


def test_stops_are_located_to_round_off() -> None:
    """A pendulum from 2 rad: quarter period from theta = 0, half period from its rate, the angle's value, its height."""
    case = CASES["B04"]
    go = compiled(of_case(case))
    period = float(case["times"][0]) / 10
    quarter = go([2.0], [0.0], 0.0, 10.0, 1e-15, stop=Stop("q", 0))
    assert quarter.outcome == "event"
    assert abs(quarter.t - period / 4) < 4e-16 and abs(quarter.q[0]) < 1e-15
    half = go([2.0], [0.0], 0.0, 10.0, 1e-15, stop=Stop("v", 0))
    assert abs(half.t - period / 2) < 1e-15
    rising = go([2.0], [0.0], 0.0, 10.0, 1e-15, stop=Stop("q", 0, direction=1))
    assert abs(rising.t - 3 * period / 4) < 1e-15
    level = go([2.0], [0.0], 0.0, 10.0, 1e-15, stop=Stop("depth", 0, value=math.cos(1.0)))
    angle = go([2.0], [0.0], 0.0, 10.0, 1e-15, stop=Stop("q", 0, value=1.0))
    assert abs(level.t - angle.t) < 1e-15 and abs(level.q[0] - 1.0) < 1e-15
    back = go([2.0], [0.0], 10.0, 0.0, 1e-15, stop=Stop("q", 0))
    assert abs(back.t - (10.0 - period / 4)) < 4e-15


def test_a_stop_does_not_stop_the_run_again() -> None:
    go = compiled(planar(2))
    q, v, t, lost, met = np.array([0.4, 0]), np.zeros(2), 0.0, None, []
    while t < 3.0:
        part = go(q, v, t, 3.0, 1e-13, stop=Stop("q", 1), lost=lost)
        q, v, t, lost = part.q, part.v, part.t, part.lost
        met += [t] if part.outcome == "event" else []
    signs = go([0.4, 0], [0, 0], 0.0, 3.0, 1e-13, times=np.linspace(0, 3, 3001)).q_at[1:, 1] > 0
    assert len(met) == np.count_nonzero(np.diff(signs))


def test_times_after_a_stop_are_not_written() -> None:
    found = compiled(of_case(CASES["B04"]))(
        [2.0], [0.0], 0.0, 10.0, 1e-15, times=[0.1, 0.2, 5.0], stop=Stop("q", 0)
    )
    assert len(found.q_at) == len(found.v_at) == 2


def test_an_equilibrium_is_kept() -> None:
    found = compiled(planar(2))([0, 0], [0, 0], 0.0, 10.0, 1e-12)
    assert found.outcome == "done" and not found.q.any() and not found.v.any()


def test_without_gravity_a_link_turns_at_its_rate() -> None:
    """No linear mode bounds the step, and at rest nothing moves at all."""
    chain = scene("afloat", "planar", "fixed", links=1, mass=1, length=1, gravity=0)
    turning, still = (compiled(chain)([0.5], [rate], 0.0, 100.0, 1e-12) for rate in (0.25, 0.0))
    assert abs(turning.q[0] - 25.5) < 1e-13 and turning.v[0] == 0.25
    assert still.outcome == "done" and still.q[0] == 0.5


def test_small_motions_keep_their_digits() -> None:
    """At 1e-9 rad the motion is the linear one; an absolute tolerance would see nothing of it."""
    go = compiled(planar(1))
    found = go([1e-9], [0.0], 0.0, 100.0, 1e-13)
    rate = math.sqrt(9.81 / 0.5)
    assert abs(found.q[0] / 1e-9 - math.cos(100 * rate)) < 1e-11


def test_runtime_parameters_are_those_of_the_folded_scene() -> None:
    given = {"mass": [1.0, 0.5], "length": [1.0, 0.7], "com": [0.5, 0.3]}
    folded = scene("folded", "planar", "fixed", links=2, **given)
    runtime = scene("given", "planar", "fixed", links=2, **dict.fromkeys(given, "runtime"))
    one = compiled(folded)([1, 2], [0, 1], 0.0, 1.0, 1e-14)
    two = compiled(runtime)([1, 2], [0, 1], 0.0, 1.0, 1e-14, p={k: np.array(x) for k, x in given.items()})
    assert np.max(np.abs(np.append(one.q - two.q, one.v - two.v))) < 1e-12


def test_single_precision() -> None:
    chain = planar(2, "single", target={"real": "float"})
    single, double = (compiled(c)([0.4, 0], [0, 0], 0.0, 2.0, 1e-5) for c in (chain, planar(2)))
    assert single.outcome == "done"
    assert np.max(np.abs(single.q - double.q)) < 1e-4


@pytest.mark.parametrize("tol", [1e-6, 1e-9, 1e-12])
def test_errors_follow_the_tolerance(tol: float) -> None:
    go = compiled(planar(2))
    exact = go([0.4, 0], [0, 0], 0.0, 20.0, 1e-15)
    found = go([0.4, 0], [0, 0], 0.0, 20.0, tol)
    assert np.max(np.abs(found.q - exact.q)) < tol
    assert found.steps < exact.steps and found.order <= exact.order


# --- trouble ---------------------------------------------------------------------------------------------------------------


def test_a_state_that_overflows_is_said() -> None:
    found = compiled(planar(2))([0.4, 0], [1e200, -1e200], 0.0, 1.0, 1e-12)
    assert found.outcome == "not finite"
    assert found.t == 0.0 and found.v[0] == 1e200


def test_tolerances_below_round_off_are_raised() -> None:
    assert compiled(planar(1))([0.4], [0.0], 0.0, 1.0, 1e-30).tol == EPS


@pytest.mark.parametrize(
    ("change", "error", "field"),
    [
        ({"q": [0.1]}, ArrayError, "q"),
        ({"v": [math.nan, 0]}, ArrayError, "v"),
        ({"tol": 0.0}, ToleranceError, "tol"),
        ({"tol": math.nan}, ToleranceError, "tol"),
        ({"t_end": math.inf}, ArrayError, "propagate.t"),
        ({"times": [0.5, 0.2]}, ArrayError, "times"),
        ({"times": [2.0]}, ArrayError, "times"),
        ({"stop": Stop("q", 2)}, ArrayError, "stop.index"),
    ],
)
def test_bad_input_is_refused(change: dict[str, Any], error: type[Exception], field: str) -> None:
    arguments: dict[str, Any] = {"q": [0.1, 0.2], "v": [0, 0], "t": 0.0, "t_end": 1.0, "tol": 1e-9}
    with pytest.raises(error, match=field):
        compiled(planar(2))(**(arguments | change))


def test_stops_are_checked_when_they_are_made() -> None:
    wrong: tuple[dict[str, Any], ...] = ({"scalar": "speed"}, {"direction": 2}, {"value": math.nan})
    for bad in wrong:
        with pytest.raises(ArrayError, match="stop"):
            Stop(**({"scalar": "q", "index": 0} | bad))
