"""Swing-up from a scene to C: the plan against an integrator of its own, trials of the compiled law, routes, files, refusals."""

from __future__ import annotations

import json
import subprocess
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from phichain import build, generate_swingup, simulate, swing_up
from phichain.app.cli import main
from phichain.control import Sensors
from phichain.control.swing_up import Chain, Plan, Task, planned, starts
from phichain.control.swing_up.solve import _finer
from phichain.control.swing_up.transcription import Problem, Solution
from phichain.errors import ArrayError, ControlError, OutputError, SceneError, UnsupportedError
from phichain.records import thawed
from phichain.scene import Scene, scene_from_dict
from phichain.system import System
from phichain.trials import SwingUp
from tests import tables
from tests.handmade import planar

M0, M, L, G = 0.5, 0.1, 0.2, 9.81

POLE = Scene(
    "pole", 1, base="cart", cart_mass=M0, mass=M, length=L, actuated="cart", want=("forward_dynamics", "linearization", "propagate"),
)  # fmt: skip

search = import_module("phichain.trials.swing_up")  # the module, whose name the package gives to its function

COMPILE = ("cc", "-std=c99", "-O2", "-Wall", "-Wextra", "-Werror", "-pedantic-errors", "-Wconversion", "-Wdouble-promotion")


@pytest.fixture(scope="module")
def system() -> System:
    return build(POLE)


@pytest.fixture(scope="module")
def found(system: System) -> SwingUp:
    """One search, with wrong masses and starts."""
    return swing_up(system, limit=20, rail=0.5, errors={"mass": 0.1, "cart_mass": 0.1}, runs=60, count=2, jobs=1)


def pole(x: np.ndarray, u: float, m: float = M, m0: float = M0) -> list[float]:
    """A point mass on a rod on a cart, from the textbook: theta from hanging, positive towards +x."""
    s, c, w = np.sin(x[1]), np.cos(x[1]), x[3]
    a = (u + m * L * w**2 * s + m * G * s * c) / (m0 + m * s**2)
    return [x[2], w, a, -(c * a + G * s) / L]


def test_the_chain_runs_through_the_plan(found: SwingUp) -> None:
    """Another integrator on other equations, the inputs held from sample to sample: a tenth of a second at a time."""
    plan = found.plan
    assert np.allclose(plan.x[0], 0, atol=1e-12) and np.allclose(plan.x[-1], [0, np.pi, 0, 0], atol=1e-3)
    assert np.max(np.abs(plan.x[:, 0])) < 0.5 and np.max(np.abs(plan.u)) < 20 and plan.converged
    for start in range(0, len(plan.u) - 100, 100):
        x = plan.x[start]
        for k in range(start, start + 100):
            x = solve_ivp(lambda t, z, u: pole(z, u), (0, plan.sample), x, args=(plan.u[k, 0],), rtol=1e-9, atol=1e-11).y[:, -1]
        assert np.allclose(x, plan.x[start + 100], atol=1e-7)


def test_it_survives_wrong_masses_and_says_so(found: SwingUp) -> None:
    trials = found.trials
    assert trials.share == 1.0 and len(trials.held) == 60 and 0.93 < trials.interval[0] < 0.95 and trials.interval[1] == 1.0
    assert np.max(np.abs(trials.errors)) > 0.09 and np.ptp(trials.starts[:, 1]) > 0.08 and not np.ptp(trials.starts[:, 0])
    assert found.law.note.startswith("Of 60 runs with starts within 0.05 rad and mass within 0.1")
    assert found.law.digest == found.plan.digest == POLE.digest
    assert "100.0%" in str(found) and found.tried[0].plan is not None


def test_a_start_that_is_too_far_off_is_named_as_the_bound(system: System, found: SwingUp) -> None:
    """More than a radian off, its tube, the law gives up at once; nearer than what is named no run is lost."""
    far = swing_up(system, limit=20, rail=0.5, errors={"mass": 0.1, "cart_mass": 0.1}, runs=60, count=1, jobs=1, spread=1.6)
    off = np.abs(far.trials.starts[:, 1])
    assert far.tried[0].again and far.trials.share < 0.95 and not np.any(far.trials.held[off > 1]) and found.within is None
    assert far.within in (0.8, 0.4, 0.2) and np.all(far.trials.held[off < far.within])
    assert f"hold that start within {far.within:g} rad" in str(far) and far.law.note.endswith(f"where they start within {far.within:g} rad.")


def test_of_halved_spreads_the_first_one_that_is_enough_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    def within(spread: float, shares: dict[float, float]) -> float | None:
        monkeypatch.setattr(search, "trials_of", lambda *_, seed, spread: SimpleNamespace(share=shares[spread]))
        return search._within(SimpleNamespace(spread=spread), None, 10, 0.9)  # type: ignore[arg-type]

    assert within(0.8, {0.4: 0.5, 0.2: 0.9}) == 0.2
    assert within(0.8, {0.4: 0.5, 0.2: 0.8, 0.1: 0.89}) is None and within(0.0, {}) is None


def test_the_law_swings_the_emitted_flow_up(system: System, found: SwingUp) -> None:
    """The record itself as sampled law on the Taylor flow; the trials ran the compiled one by Runge and Kutta."""
    end = found.law.duration + 0.5
    motion = simulate(system, np.array([0.0, 0.05, 0.0, 0.0]), np.array([0.0, end]), u=found.law, sample=1e-3, tol=1e-9)
    assert np.allclose(motion.x[-1], [0, np.pi, 0, 0], atol=2e-2)


def test_it_holds_through_encoders_and_says_so(system: System, found: SwingUp, tmp_path: Path) -> None:
    """256 counts a turn; the same plan, the compiled law on positions in steps; the same record on the emitted flow."""
    coarse = Sensors(resolution={"theta_1": 2 * np.pi / 256, "x": 1e-3})
    seen = swing_up(system, limit=20, rail=0.5, errors={"mass": 0.1, "cart_mass": 0.1}, runs=60, count=1, jobs=1, sensors=coarse)
    assert seen.tried[0].again and seen.trials.share == 1.0 and seen.law.note.endswith("hold it through the observer, from positions in the steps of their sensors.")
    assert np.max(np.abs(seen.law.catch.gains)) < 0.9 * np.max(np.abs(found.law.catch.gains))
    steps = np.array([1e-3, 2 * np.pi / 256])
    law = seen.law.running(lambda y: steps * np.round(y / steps))
    motion = simulate(system, np.array([0.0, 0.05, 0.0, 0.0]), np.array([0.0, seen.law.duration + 0.5]), u=law, sample=1e-3, tol=1e-9)
    assert np.allclose(motion.x[-1, :2], [0, np.pi], atol=5e-2)
    with pytest.raises(ControlError, match="measured: are not the positions"):
        swing_up(system, limit=20, rail=0.5, runs=2, count=1, jobs=1, sensors=Sensors(measured=("x",)))


def test_finer_intervals_keep_the_nodes_and_lie_on_the_motion(system: System) -> None:
    """A motion under a force that rises evenly, by SciPy: nodes stay, those in between are right to the fourth order of the interval."""
    chain, slope = Chain(system), 3.0

    def at(K: int) -> np.ndarray:
        run = solve_ivp(lambda t, z: pole(z, slope * t), (0, 1), [0, 0.5, 0, 0], t_eval=np.linspace(0, 1, K + 1), rtol=1e-11, atol=1e-12)
        return np.vstack([run.y, slope * run.t]).T

    errors = []
    for K in (20, 40):
        nodes, slopes = _finer(chain, Solution(True, 1.0, at(K), np.full((K, 1), slope), 0.0, 0.0, 0))
        assert nodes.shape == (2 * K + 1, 5) and np.allclose(nodes[::2], at(K), rtol=1e-13, atol=1e-15) and np.all(slopes == slope) and len(slopes) == 2 * K
        errors.append(np.max(np.abs(nodes - at(2 * K))))
    assert errors[0] < 1e-3 and errors[0] / errors[1] > 11


def test_routes_stop_at_the_hanging_chain_and_at_unfolded_poses() -> None:
    def stops(start: tuple[int, ...], target: tuple[int, ...]) -> list[list[tuple[int, ...]]]:
        task = Task.of(planar([0.1] * len(start), [0.2] * len(start), cart_mass=0.5, actuated="cart"), limit=20.0, start=start, target=target)
        return [[leg.target for leg in legs[:-1]] for legs in task.routes]

    hanging, up = (1, 1, 1), (-1, -1, -1)
    assert stops(hanging, up) == [] and stops(hanging, (1, -1, -1)) == []
    assert stops(up, (1, -1, -1)) == [[hanging]]
    assert stops(hanging, (1, -1, 1)) == [[(1, -1, -1)]]
    assert stops((-1, 1, -1), (1, -1, 1)) == [[hanging], [hanging, (1, -1, -1)]]
    assert stops((-1, 1, 1), (-1, 1, -1)) == [[hanging], [up, hanging]] and stops((-1, 1, 1), up) == [[hanging]]


@pytest.mark.long
def test_a_route_is_one_plan_that_rests_in_between() -> None:
    """Two links from one pose to the other: two motions that meet at rest, hanging, under one input within its limit."""
    two = build(replace(POLE, name="two_poles", links=2, mass=M, length=L, com=L))
    task = Task.of(two, limit=20.0, rail=1.0, start=(-1, -1), target=(1, -1), places=(0.1, 0.3))
    assert [leg.target for leg in task.routes[0]] == [(1, 1), (1, -1)] and task.routes[0][0].last[0] == pytest.approx(0.2)
    every = starts(task, 5)
    assert [one.route for one in every] == [0, 1, 0, 1, 0] and every[0].seconds == every[1].seconds
    chain = Chain(two)
    plan, left = planned(chain, task, Problem(chain, task, intervals=40), every[1], 5)
    assert plan is not None and plan.converged and plan.duration == pytest.approx(2 * every[1].seconds, abs=0.01)
    middle = plan.x[len(plan.x) // 2]
    assert np.allclose(middle, [0.2, 0, 0, 0, 0, 0], atol=0.1) and np.max(np.abs(plan.u)) <= 20
    assert np.allclose(plan.x[0], task.first.tolist() + [0] * 3) and np.allclose(plan.x[-1][:3], task.last, atol=0.01)
    assert left.iterations > 20 and plan.cost == left.cost


def test_a_plan_that_whirls_is_bounded_and_led() -> None:
    """Without its bound the step of an interval is wrong by radians, and the chain cannot be led along what it says."""
    scene = Scene("whirl", 2, base="cart", cart_mass=1.0, mass=[0.2, 0.1], length=[0.25, 0.2], com=[0.125, 0.02], want=("forward_dynamics", "linearization"))
    chain = Chain(build(scene))
    task = Task.of(chain.system, limit=40, rail=1.0)
    problem = Problem(chain, task, intervals=40)
    seconds = 1.2
    guess = np.zeros((41, 7)), np.zeros((40, 1))
    guess[0][:, :3] = task.first + (task.last - task.first) * np.linspace(0, 1, 41)[:, None]
    bounded = problem.solve(seconds, *guess, 0.0, 0.85, 0.3)
    assert bounded.converged and np.max(np.abs(bounded.nodes[:, 4:6])) * seconds / 40 < 0.3 * (1 + 1e-6)
    free = problem.solve(seconds, *guess, 0.0, 0.85)
    assert np.max(np.abs(free.nodes[:, 4:6])) * seconds / 40 > 0.3


def test_a_plan_on_file_is_the_same_record(found: SwingUp, tmp_path: Path) -> None:
    again = Plan.from_npz(found.plan.to_npz(tmp_path / "plan.npz"))
    assert all(np.array_equal(getattr(again, name), value) for name, value in vars(found.plan).items())
    assert tables.lines(found.plan.to_csv(tmp_path / "plan.csv"))[0] == "t,x,theta_1,x_dot,theta_dot_1,force"
    with pytest.raises(OutputError, match="no Plan can be read there"):
        Plan.from_npz(tmp_path / "plan.csv")


def test_the_same_problem_goes_on_with_what_it_has(system: System, found: SwingUp) -> None:
    """Plans are remembered whatever they are tried for, and another limit is another problem."""
    again = swing_up(system, limit=20, rail=0.5, errors={"mass": 0.1, "cart_mass": 0.1}, runs=4, count=1, jobs=1)
    assert again.tried[0].again and np.array_equal(again.plan.x, found.tried[0].plan.x)
    tables = thawed(system.scene)
    assert scene_from_dict(tables) == POLE


def test_the_command_writes_what_passes_its_own_test(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """From the wall of the rail to the other, hanging: point to point; by the record's drive through acceleration."""
    (tmp_path / "mover.toml").write_text(
        'name = "mover"\n[chain]\nlinks = 1\nbase = "cart"\ndrive = "acceleration"\nmass = 0.1\nlength = 0.2\n'
        '[functions]\nwant = ["forward_dynamics", "linearization"]\n'
    )
    words = [str(tmp_path / "mover.toml"), "--limit", "5", "--rail", "0.6", "--to", "none", "--places=-0.3,0.3", "--error", "length=0.05"]
    with pytest.raises(SystemExit) as leaving:
        main(["swingup", *words, "--runs", "20", "--jobs", "1", "--out", str(tmp_path), "--save", str(tmp_path / "plan.png")])
    assert leaving.value.code == 0
    said = capsys.readouterr()
    assert "20 of 20 runs" in said.out and "100.0% hold" in said.err and (tmp_path / "plan.png").stat().st_size > 10_000
    folder = tmp_path / "mover_swingup"
    sources = [str(path) for path in folder.glob("*.c")]
    made = subprocess.run([*COMPILE, *sources, "-lm", "-o", str(tmp_path / "t")], capture_output=True, text=True, check=False)
    assert made.returncode == 0, made.stderr
    assert subprocess.run([str(tmp_path / "t")], check=False).returncode == 0
    record = json.loads((folder / "manifest.json").read_text())
    assert record["state"][0][2:4] == [-0.3, 0.3] and record["inputs"] == [["acceleration", "m/s^2", -5.0, 5.0]]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--resolution", "0.001"], "resolution: says something of --observer, which is not asked for"),
        (["--observer", "reduced"], "observer: is no observer along a motion"),
    ],
)
def test_words_of_sensors_are_refused_before_anything_is_planned(words: list[str], said: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as leaving:
        main(["swingup", "rig_cart_pole", "--limit", "5", *words])
    assert leaving.value.code == 2 and said in capsys.readouterr().err


@pytest.mark.long
def test_limits_that_leave_no_motion_name_the_bound(system: System) -> None:
    with pytest.raises(ControlError, match="rail: is the bound that leaves no motion in 1.5 s: without it there is one that goes") as short:
        swing_up(system, limit=20, rail=0.01, seconds=1.5, count=1, runs=2, most=80)
    assert short.value.bound == "rail" and short.value.needed > 0.1
    with pytest.raises(ControlError, match="limit: is the bound that leaves no motion in 0.8 s: with more there is one that takes") as weak:
        swing_up(system, limit=1.5, seconds=0.8, count=1, runs=2, most=80)
    assert weak.value.bound == "limit" and weak.value.needed > 1.5


def test_a_solver_that_stops_early_makes_a_law_only_when_asked_and_says_so(system: System, tmp_path: Path) -> None:
    given = {"limit": 20, "rail": 0.5, "seconds": 1.5, "count": 1, "runs": 10, "jobs": 1}
    with pytest.raises(ControlError, match="none of 1 starts converged: the least infeasibility is"):
        swing_up(system, most=16, **given)
    found = swing_up(system, most=16, anyway=True, **given)
    assert not found.plan.converged and found.law.note.startswith("NOT CONVERGED: the solver stopped after 1")
    header = (generate_swingup(found.law, tmp_path) / "pole_swingup.h").read_text()
    assert " * NOT CONVERGED: the solver stopped after 1" in header


@pytest.mark.parametrize(
    ("more", "kind", "words"),
    [
        ({"target": [1]}, ControlError, "target: is where the chain starts"),
        ({"target": [-1, 1]}, ControlError, "is no equilibrium: a vertical chain has one sign per link, 1 of them"),
        ({"limit": -3}, ControlError, "limit: is no positive size of every input"),
        ({"rail": -1}, ControlError, "rail: is no positive length"),
        ({"rail": 0.2, "places": (0.0, 0.5)}, ControlError, "rail: ends before the cart's place at 0.5 m"),
        ({"sample": 0.0}, ControlError, "sample: is no positive time"),
        ({"errors": {"mas": 0.1}}, SceneError, "error: is no parameter that this chain has as numbers"),
        ({"errors": {"mass": 2}}, SceneError, "error: is no relative error of mass"),
        ({"errors": {"damping": 0.1}}, SceneError, "error: is no parameter that this chain has as numbers"),
        ({"spread": -1}, ControlError, "spread: is no error of an angle"),
        ({"solver": "magic"}, ArrayError, "solver: is no solver of ours"),
        ({"runs": 0}, ArrayError, "runs: is no number of runs"),
    ],
)
def test_what_is_no_task_is_refused(system: System, more: dict[str, object], kind: type[Exception], words: str) -> None:
    with pytest.raises(kind, match=words):
        swing_up(system, **{"limit": 20, "jobs": 1, "count": 1, "runs": 2, "seconds": 1.5, **more})  # type: ignore[arg-type]


def test_chains_that_have_none_say_what_to_use() -> None:
    with pytest.raises(UnsupportedError, match="has no swing-up: its trajectories are planned in angles"):
        space = Scene("ball", 1, "spatial", "cart", mass=0.1, length=0.1, cart_mass=0.5, want=("forward_dynamics", "linearization"))
        swing_up(build(space), limit=1)
    with pytest.raises(ControlError, match="nothing pushes this chain"):
        swing_up(build(Scene("still", 1, mass=0.1, length=0.1, want=("forward_dynamics", "linearization"))), limit=1)
    with pytest.raises(UnsupportedError, match="was not built from a scene"):
        swing_up(planar([0.3], [0.4], cart_mass=0.7, actuated="cart"), limit=1)
    with pytest.raises(ControlError, match="belongs to a cart"):
        fixed = Scene("arm", 1, mass=0.1, length=0.1, actuated="all", want=("forward_dynamics", "linearization"))
        swing_up(build(fixed), limit=1, rail=1)
