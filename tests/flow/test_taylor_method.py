"""The flow behind the interface of `simulate`: whole runs and single steps, events, budgets, trouble."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from phichain.errors import UnsupportedError
from phichain.ir.evaluate import evaluate
from phichain.lowering.lower import lower_function
from phichain.mechanics import derive
from phichain.motion.events import Event, as_events
from phichain.motion.ledger import Ledger
from phichain.motion.methods import taylor
from phichain.motion.path import StalledError, collect
from phichain.motion.problem import Problem, bind
from phichain.scene import Scene
from phichain.system import System
from tests.flow.flows import compiled, planar

CHAIN = planar(2)
DRIVEN = planar(2, "driven", joints={"actuated": "all"})


def system_of(chain: Scene) -> System:
    dynamics = lower_function(derive(chain), "forward_dynamics", "loops")
    names = [array.name for array in dynamics.inputs]

    def forward_dynamics(*values: Any) -> Any:
        return evaluate(dynamics, dict(zip(names, values, strict=True)))["a"]

    functions = {"forward_dynamics": forward_dynamics, "propagate": compiled(chain)}
    return System(
        chain.name, chain.space, chain.base, chain.links, chain.nq, chain.nv, chain.nu, functions=functions
    )


def problem(t: Any, chain: Scene = CHAIN, x0: Any = (0.4, 0, 0, 0), u: Any = None, **more: Any) -> Problem:
    system, times, state = system_of(chain), np.array(t, dtype=float), np.array(x0, dtype=float)
    field, jacobian, control, held = bind(system, u, None, times[0], state)
    made = Problem(
        system, field, jacobian, control, held, None, state, times, 1e-12, 1e-14, None, (), 100_000, None
    )  # fmt: skip
    return replace(made, **more)


def test_whole_runs_and_single_steps_agree() -> None:
    grid = problem(np.linspace(0, 5, 11))
    ledger = Ledger()
    whole, single = taylor.path(grid, "taylor", ledger), collect(grid, taylor.segments(grid, "taylor", Ledger()))
    assert whole.status == single.status == "complete"
    assert whole.t.tolist() == single.t.tolist() == grid.t.tolist()
    assert np.max(np.abs(whole.x - single.x)) < 1e-12
    assert ledger.counts["steps"] == whole.steps and ledger.counts["order"] > 10


def test_backwards_from_where_it_came_to() -> None:
    there = taylor.path(problem([0, 1, 3]), "taylor", Ledger())
    back = taylor.path(problem([3, 2, 0], x0=there.x[-1]), "taylor", Ledger())
    assert np.max(np.abs(back.x[-1] - [0.4, 0, 0, 0])) < 1e-12


def test_own_steps_have_the_series_between_them() -> None:
    asked = problem([0, 2])
    found, stepped = taylor.path(asked, "taylor", Ledger()), collect(asked, taylor.segments(asked, "taylor", Ledger()))
    assert found.dense is not None and stepped.dense is not None
    assert found.t.tolist() == stepped.t.tolist() and np.max(np.abs(found.x - stepped.x)) < 1e-15
    times = np.linspace(0.1, 1.9, 7)
    exact = taylor.path(problem([0, *times, 2]), "taylor", Ledger()).x[1:-1]
    for dense in (found.dense, stepped.dense):
        assert np.max(np.abs(dense(times[::-1])[::-1] - exact)) < 1e-12


def test_events_are_found_within_the_steps() -> None:
    watched = as_events(Event("first link hangs", lambda t, x: x[0], terminal=True))
    asked = problem([0, 5], events=watched)
    found = collect(asked, taylor.segments(asked, "taylor", Ledger()))
    assert found.status == "event"
    assert abs(found.x[-1][0]) < 1e-15


def test_a_constant_input_is_held() -> None:
    found = taylor.path(problem([0, 1], DRIVEN, u=[0.02, -0.01]), "taylor", Ledger())
    free = taylor.path(problem([0, 1], DRIVEN), "taylor", Ledger())
    assert np.max(np.abs(found.x[-1] - free.x[-1])) > 1e-3


def test_inputs_that_move_are_refused() -> None:
    asked = problem([0, 1], DRIVEN, u=lambda t, x: np.array([math.sin(t), 0.0]))
    assert not taylor.is_possible(asked)
    with pytest.raises(UnsupportedError, match="constant"):
        taylor.path(asked, "taylor", Ledger())


def test_a_system_without_a_flow_says_so() -> None:
    asked = problem([0, 1])
    bare = replace(asked.system, functions={"forward_dynamics": asked.system.functions["forward_dynamics"]})
    with pytest.raises(UnsupportedError, match="propagate"):
        taylor.path(replace(asked, system=bare), "taylor", Ledger())


def test_the_budget_ends_a_run_with_what_there_is() -> None:
    found = taylor.path(problem(np.linspace(0, 50, 101), max_steps=40), "taylor", Ledger())
    assert found.status == "step budget" and found.steps == 40
    assert "40 steps" in found.message
    assert 0 < found.t[-1] < 50 and len(found.t) == len(found.x)


def test_a_blow_up_is_told_with_its_time() -> None:
    asked = problem([0, 1, 2], x0=[0.4, 0, 1e200, 0])
    assert taylor.path(asked, "taylor", Ledger()).status == "blow-up"
    with pytest.raises(StalledError, match="finite"):
        list(taylor.segments(asked, "taylor", Ledger()))


def test_progress_is_told() -> None:
    told: list[float] = []
    taylor.path(problem(np.linspace(0, 1, 5), progress=lambda done, t: told.append(done)), "taylor", Ledger())
    assert told == sorted(told) and told[-1] == 1.0
