"""Stiff scenes through `simulate`: the emitted flow, and the exact Jacobians that SciPy and SUNDIALS work with."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from phichain.errors import UnsupportedError
from phichain.ir.evaluate import evaluate
from phichain.lowering.lower import lower_function
from phichain.mechanics import derive
from phichain.motion import Event, choose, simulate
from phichain.motion.problem import Problem, bind
from phichain.pipeline import build
from phichain.scene import Scene
from phichain.system import rhs_jacobian
from tests.stiff.systems import SCENES, spatial_start, system

CASES = json.loads((Path(__file__).parents[1] / "data" / "extreme_cases.json").read_text())["cases"]
EXPECTED = np.array(next(case for case in CASES if case["id"] == "B10")["reference"]["5.0"], dtype=float)
START = ([1.0, 1e-3], [0.0, 0.0])


def test_a_grid_runs_in_compiled_code() -> None:
    told: list[float] = []
    run = simulate(
        system("rigid_joint"),
        START,
        np.linspace(0, 5, 6),
        "rosenbrock",
        1e-13,
        progress=lambda done, t: told.append(done),
    )
    assert run.status == "complete" and run.t.tolist() == [0, 1, 2, 3, 4, 5]
    assert np.max(np.abs(run.x[-1] - EXPECTED)) < 1e-12
    assert run.counts["order"] == 5 and run.counts["steps"] > 1000 and told[-1] == 1.0


def test_own_steps_and_what_lies_between() -> None:
    run = simulate(system("rigid_joint"), START, (0.0, 1.0), "rosenbrock", 1e-9)
    assert len(run.t) == run.counts["steps"] + 1 and run.t[-1] == 1.0
    between = run.refine(np.linspace(0.0, 1.0, 7))  # type: ignore[misc]
    exact = simulate(system("rigid_joint"), START, np.linspace(0.0, 1.0, 7), "rosenbrock", 1e-13)
    assert np.max(np.abs(between.x - exact.x)) < 1e-8


def test_events_stop_it() -> None:
    """The first swing through the vertical: theta_1 = 0 of a rod, near enough, of two masses."""
    falls = Event("vertical", lambda t, x: x[0], terminal=True)
    run = simulate(system("rigid_joint"), START, (0.0, 5.0), "rosenbrock", 1e-11, events=falls)
    assert run.status == "event" and abs(run.q[-1, 0]) < 1e-12
    again = simulate(system("rigid_joint"), START, (0.0, float(run.t[-1])), "rosenbrock", 1e-13)
    assert abs(again.q[-1, 0]) < 1e-10


def test_auto_takes_it_where_a_scene_is_stiff() -> None:
    run = simulate(system("rigid_joint"), START, (0.0, 0.1), tol=1e-8)
    assert run.method == "rosenbrock" and "auto took rosenbrock" in run.reason and "stiff" in run.reason
    assert simulate(system("free_pair"), START, (0.0, 0.1), tol=1e-8).method == "DOP853"


def test_an_undamped_scene_is_not_asked_for_eigenvalues(monkeypatch: pytest.MonkeyPatch) -> None:
    """And they would have said the same: springs, light links, fast motion, both ways in time."""
    spread = Scene("spread", 3, mass=[1.0, 1e-4, 1.0], length=[1.0, 0.1, 0.5], stiffness=1e3, want=["forward_dynamics", "state_jacobian"])
    chain, rng = build(spread), np.random.default_rng(5)
    run = simulate(chain, (rng.uniform(-1, 1, 3), np.zeros(3)), (0.0, 1e-3), tol=1e-8)
    assert "nothing damps the chain" in run.reason and "jacobian" not in {k for k, n in run.counts.items() if n}
    monkeypatch.setattr(choose, "is_undamped", lambda problem: False)
    for end in (50.0, -50.0):
        for _ in range(20):
            x0 = rng.uniform(-3, 3, 6) * np.repeat([1.0, 10.0], 3)
            field, jacobian, control, held = bind(chain, None, None, 0.0, x0)
            problem = Problem(chain, field, jacobian, control, held, None, x0, np.array([0.0, end]), 1e-4, 1e-6, None, (), 10, None)
            assert choose.choose(problem)[0] == "DOP853"


def test_a_law_may_damp_an_undamped_scene() -> None:
    driven = build(Scene("driven", 1, mass=1.0, length=1.0, actuated="all", want=["forward_dynamics", "state_jacobian"]))
    held = simulate(driven, [0.5, 0.0], (0.0, 10.0), tol=1e-6, u=lambda t, x: -1e5 * x[1:])
    assert held.method == "Radau" and "what decays fastest, by 1e+05 per second," in held.reason
    damped = simulate(system("rigid_joint"), START, (0.0, 0.01), tol=1e-8)
    assert "decays fastest" in damped.reason


def test_spatial_runs_stay_on_the_manifold() -> None:
    run = simulate(
        system("spatial_stiff"), spatial_start(2, 2), (0.0, 0.2), "rosenbrock", 1e-8, p={"mass": [1.0, 0.7]}
    )
    assert np.max(np.abs(run.length_error)) < 1e-15 and np.max(np.abs(run.tangency_error)) < 1e-14  # type: ignore[arg-type]


def test_what_it_cannot_do_is_said() -> None:
    with pytest.raises(UnsupportedError, match="holds its input constant"):
        state = np.concatenate(spatial_start(2, 2))
        simulate(
            system("spatial_stiff"),
            state,
            (0.0, 0.1),
            "rosenbrock",
            u=lambda t, x: np.zeros(2),
            p={"mass": [1.0, 1.0]},
        )
    spent = simulate(system("rigid_joint"), START, np.linspace(0, 5, 3), "rosenbrock", 1e-12, max_steps=50)
    assert spent.status == "step budget" and 0 < spent.t[-1] < 2.5


# --- what others integrate with ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("method", ["Radau", "BDF", "LSODA"])
def test_scipy_gets_the_exact_jacobian(method: str) -> None:
    """Differences would cost four right-hand sides a Jacobian, and err by 1e-8 of 1e13."""
    pair = system("rigid_joint")
    seen: list[Any] = []

    def watched(*state: Any) -> Any:
        seen.append(state)
        return pair.state_jacobian(*state)

    spied = replace(pair, functions={**pair.functions, "state_jacobian": watched})
    run = simulate(spied, START, (0.0, 0.5), method, 1e-6)
    assert run.status == "complete" and len(seen) >= run.counts["jacobian"] > 0
    blind = replace(
        pair, functions={name: f for name, f in pair.functions.items() if name != "state_jacobian"}
    )
    assert "jacobian" not in simulate(blind, START, (0.0, 0.01), method, 1e-6).counts


def test_that_jacobian_is_the_complex_step_of_the_oracle() -> None:
    state = np.array([1.0, 1e-9, 0.3, -0.2])
    found = rhs_jacobian(system("rigid_joint"))(0.0, state)
    program = lower_function(derive(SCENES["rigid_joint"]), "forward_dynamics")
    for column in range(4):
        moved = state.astype(complex)
        moved[column] += 1e-40j
        a = evaluate(program, {"q": moved[:2], "v": moved[2:]})["a"].imag / 1e-40
        expected = np.append(moved[2:].imag / 1e-40, a)
        assert np.max(np.abs(found[:, column] - expected)) <= 1e-14 * np.max(np.abs(expected))


@pytest.mark.parametrize("method", ["cvodes", "idas"])
def test_sundials_gets_exact_jacobians(method: str) -> None:
    """CasADi differentiates the graph: its Jacobian is the emitted one, and a joint of 1e13 N m/rad is no obstacle."""
    casadi = pytest.importorskip("casadi")
    pair = system("rigid_joint")
    dynamics = pair.function("casadi")
    dynamics = dynamics if isinstance(dynamics, casadi.Function) else dynamics()
    q, v = np.array([1.0, 1e-9]), np.array([0.3, -0.2])
    slopes = dynamics.jacobian()(q, v, np.zeros(2))
    for name, exact in zip(("jac_a_q", "jac_a_v"), pair.state_jacobian(q, v), strict=True):
        found = np.array(slopes[dynamics.jacobian().index_out(name)])
        assert np.max(np.abs(found - exact)) <= 1e-12 * np.max(np.abs(exact))
    run = simulate(pair, START, np.linspace(0.0, 5.0, 3), method, 1e-9)
    assert np.max(np.abs(run.x[-1] - EXPECTED)) < 1e-4
    assert run.counts["steps"] < 50_000
