"""The ends of the flow's own steps: what single steps give, from one call of C."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from phichain.errors import ArrayError
from phichain.motion import simulate
from phichain.native.flows import motion
from phichain.native.glue.interrupts import Interruptible
from phichain.pipeline import build
from phichain.scene import Scene
from phichain.system import System
from phichain.system.propagation import Stop
from tests.flow.flows import compiled, planar

CHAIN = planar(2)
STATE = ([0.7, -0.4], [0.3, 1.0])


def single_steps(propagate: Any, q: Any, v: Any, t: float, t_end: float, tol: float) -> tuple[list[float], list[Any]]:
    """Times and states, one call a step."""
    times, states, more = [], [], {}
    while t != t_end:
        step = propagate(q, v, t, t_end, tol, max_steps=1, **more)
        t, q, v, more = step.t, step.q, step.v, {"lost": step.lost}
        times.append(t)
        states.append([*q, *v])
    return times, states


@pytest.mark.parametrize("span", [(0.0, 5.0), (2.0, -1.0)])
def test_own_steps_are_the_single_ones_to_the_last_bit(span: tuple[float, float]) -> None:
    propagate = compiled(CHAIN)
    times, states = single_steps(propagate, *STATE, *span, 1e-12)
    found = propagate(*STATE, *span, 1e-12, own=True)
    assert found.t_at.tolist() == times
    assert np.hstack([found.q_at, found.v_at]).tolist() == states
    assert found.steps == len(times) > 5 and found.outcome == "done"
    plain = propagate(*STATE, *span, 1e-12)
    assert (plain.q.tolist(), plain.v.tolist(), plain.steps) == (found.q.tolist(), found.v.tolist(), found.steps)
    assert plain.t_at.size == plain.q_at.size == 0


def test_whole_turns_are_in_the_states() -> None:
    """Wound up by hundreds of turns: beside the same states by output times, to what such angles hold."""
    propagate = compiled(CHAIN)
    start = ([1000.3, -700.1], [30.0, -41.0])
    own = propagate(*start, 0.0, 3.0, 1e-13, own=True)
    at = propagate(*start, 0.0, 3.0, 1e-13, times=own.t_at)
    assert at.t_at.tolist() == own.t_at.tolist()
    assert np.max(np.abs(own.q_at - at.q_at)) <= 4 * np.spacing(np.max(np.abs(own.q_at)))
    assert own.q_at[-1].tolist() == own.q.tolist()


def test_single_precision_and_stops() -> None:
    small = compiled(planar(2, "small", target={"real": "float"}))(*STATE, 0.0, 1.0, 1e-5, own=True)
    assert small.outcome == "done" and len(small.t_at) == small.steps and np.all(np.diff(small.t_at) > 0)
    stopped = compiled(CHAIN)(*STATE, 0.0, 5.0, 1e-12, own=True, stop=Stop("q", 0))
    assert stopped.outcome == "event" and abs(stopped.q_at[-1, 0]) < 1e-14 and stopped.t_at[-1] == stopped.t


@pytest.mark.parametrize("room", [1, 400])
def test_many_steps_come_in_pieces_that_are_the_whole(room: int, monkeypatch: pytest.MonkeyPatch) -> None:
    propagate = compiled(CHAIN)
    whole = propagate(*STATE, 0.0, 5.0, 1e-12, own=True)
    monkeypatch.setattr(motion, "ROOM", room)
    cut = propagate(*STATE, 0.0, 5.0, 1e-12, own=True)
    for name in ("t_at", "q_at", "v_at", "q", "v", "lost", "t", "steps", "outcome"):
        assert np.array_equal(getattr(cut, name), getattr(whole, name)), name
    short = propagate(*STATE, 0.0, 5.0, 1e-12, own=True, max_steps=7)
    assert short.outcome == "step budget" and short.steps == len(short.t_at) == 7
    assert propagate(*STATE, 0.0, 5.0, 1e-12, own=True, max_steps=0).t_at.size == 0


def test_own_steps_and_times_are_not_asked_for_at_once() -> None:
    with pytest.raises(ArrayError, match=r"propagate\.times: are given, and so is own.*leave one of them out"):
        compiled(CHAIN)(*STATE, 0.0, 1.0, 1e-12, own=True, times=[0.5])


@pytest.fixture(scope="module")
def system() -> System:
    return build(Scene("owned", 2, mass=1.0, length=1.0, want=("forward_dynamics", "energy", "propagate", "propagate_batch")))


@pytest.fixture
def calls(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """The symbols of C that are called."""
    found: list[str] = []
    plain = Interruptible.__call__

    def counted(self: Interruptible, *arguments: Any) -> Any:
        found.append(self._plain.__name__)
        return plain(self, *arguments)

    monkeypatch.setattr(Interruptible, "__call__", counted)
    return found


@pytest.mark.parametrize("t", [(0.0, 20.0), np.linspace(0.0, 20.0, 101)], ids=["own steps", "a grid"])
def test_simulate_is_one_call_of_the_flow_that_leaves_its_steps(system: System, calls: list[str], t: Any) -> None:
    simulate(system, STATE, (0.0, 0.1))  # the first call asks how much room the flow works in
    calls.clear()
    run = simulate(system, STATE, t)
    assert run.method == "taylor" and run.counts["steps"] > 100
    assert calls == ["owned_propagate_noted"], "all else waits to be read"
    # Neighbours fly beside these steps; the others are rows of energies and accelerations.
    run.settle()
    assert set(calls[1:]) == {"owned_errors_beside", "owned_rows_energy", "owned_rows_forward_dynamics"} and len(calls) <= 5


def test_a_resampled_run_is_one_call_more_and_the_run_itself(system: System, calls: list[str]) -> None:
    run = simulate(system, STATE, (0.0, 5.0))
    del calls[:]
    times = np.concatenate([run.t[[0, 3, 2, -1]], [2.5, 1.25]])
    again = run.resample(times)
    assert calls.count("owned_propagate") == 1
    assert np.max(np.abs(again.x[:4] - run.x[[0, 3, 2, -1]])) < 1e-14
    exact = simulate(system, STATE, [0.0, 1.25, 2.5, 5.0])
    assert np.max(np.abs(again.x[4:] - exact.x[[2, 1]])) < 1e-13
