"""What a run says of its own errors: chaos, noise, springs, and methods that lose count."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path as Path_

import numpy as np
import pytest

from phichain.motion import METHODS, Event, Table, simulate
from phichain.motion.error import estimated
from phichain.motion.error.measure import Measure
from phichain.motion.path import Path
from phichain.motion.problem import Problem, bind
from phichain.motion.trajectory import Trajectory
from phichain.pipeline import build
from phichain.scene import scene_from_dict
from phichain.system import System


@cache
def pair(angles: str = "relative", com: float = 1.0, **joints: float) -> System:
    chain = {"links": 2, "mass": 1.0, "length": 1.0, "gravity": 9.8, "com": com}
    want = {"want": ["forward_dynamics", "energy", "state_jacobian", "propagate", "propagate_stiff", "step"]}
    name = f"estimate_{angles}_{int(10 * com)}_{len(joints)}"
    return build(
        scene_from_dict(
            {"name": name, "chain": chain, "functions": want, "joints": {"angles": angles, **joints}}
        )
    )


CHAOTIC = np.array([2.0, 0.0, 0.0, 0.0])


@pytest.mark.parametrize(("method", "tol"), [("DOP853", 1e-9), ("LSODA", 1e-9), ("rosenbrock", 1e-8)])
def test_a_chaotic_motion_by_other_methods_is_doubted(method: str, tol: float) -> None:
    """Case S09 of the stability table: errors grow a hundred thousandfold in ten seconds, and more after."""
    run = simulate(pair(com=0.5), CHAOTIC, [0.0, 12.0], method, tol)
    exact = pair(com=0.5).propagate(CHAOTIC[:2], CHAOTIC[2:], 0.0, 12.0, 2.0**-52)
    assert np.max(np.abs(run.q[-1] - exact.q)) > 1e3 * tol
    assert run.status == "doubtful" and "by the Taylor flow at tolerance" in run.reason


def test_chaos_at_round_off_and_at_a_tolerance_is_doubted() -> None:
    start = np.append(np.deg2rad([120.0, -10.0]), [0.0, 0.0])
    for t, tol in ((40.0, None), (30.0, 1e-9)):
        run = simulate(pair("absolute"), start, [0.0, t], tol=tol)
        assert run.status == "doubtful" and "its estimated error, by" in run.reason
        assert ("double precision sees no farther" in run.reason) == (tol is None)
    assert simulate(pair("absolute"), start, [0.0, 5.0]).status == "complete"


def test_motions_that_keep_what_was_asked_are_not_doubted() -> None:
    calm = np.array([0.3, 0.1, 0.0, 0.0])
    for method, tol in (("auto", None), ("auto", 1e-9), ("auto", 1e-6), ("DOP853", 1e-9), ("BDF", 1e-6)):
        assert simulate(pair(), calm, [0.0, 10.0], method, tol).status == "complete"
    damped = pair(stiffness=1e8, damping=1e6)
    run = simulate(damped, calm, [0.0, 2.0], tol=1e-9)
    assert run.method == "rosenbrock" and run.status == "complete"


def test_small_motions_are_measured_by_their_own_size() -> None:
    """DOP853 with an absolute tolerance far above a motion keeps no digit of it and is doubted; auto keeps them."""
    small = np.array([1e-9, 0.0, 0.0, 0.0])
    assert simulate(pair(), small, [0.0, 10.0], tol=1e-9).status == "complete"
    rough = simulate(pair(), small, [0.0, 10.0], "DOP853", 1e-9, atol=1e-6)
    assert rough.status == "doubtful"


def test_a_stiff_method_that_lost_the_motion_is_doubted() -> None:
    """auto's implicit run against itself at ten times the tolerance: states that are off by more than asked show."""
    damped, calm = pair(stiffness=1e8, damping=1e6), np.array([0.3, 0.1, 0.0, 0.0])
    run = simulate(damped, calm, [0.0, 1.0], "rosenbrock", 1e-10)
    problem, path, method = _problem(damped, calm, 1.0, 1e-10), _path(run), METHODS["rosenbrock"]
    found = estimated(problem, path, "rosenbrock", method, 1e-9)
    assert found.reasons == () and found.holds_until == 1.0 and np.max(found.error) < 1e-9
    bent = path.x.copy()
    bent[len(bent) // 2 :] += 1e-7
    off = estimated(problem, replace(path, x=bent), "rosenbrock", method, 1e-9)
    assert len(off.reasons) == 1 and off.holds_until == path.t[len(bent) // 2 - 1]


def push(t: float, x: np.ndarray) -> np.ndarray:
    """A drive under which the pair is chaotic, and friction of its own."""
    return np.array([2.0 * np.sin(3.0 * t) - 0.1 * x[2], 0.0])


KNOTS = np.linspace(0.0, 10.0, 41)
DRIVES = {
    "law": push,
    "line": Table(KNOTS, np.column_stack([2.0 * np.sin(3.0 * KNOTS), 0.0 * KNOTS]), "linear"),
    "held": Table(KNOTS, np.column_stack([2.0 * np.sin(3.0 * KNOTS), 0.0 * KNOTS]), "held"),
}


@pytest.mark.long
@pytest.mark.parametrize(("drive", "method", "tol"), [("law", "DOP853", 1e-6), ("line", "DOP853", 1e-6), ("held", "taylor", 1e-7)])
def test_inputs_that_move_have_an_estimate(drive: str, method: str, tol: float) -> None:
    """Between a tenth and a hundred times the true error at every output, as for motions of their own."""
    system, grid = pair(actuated="all"), np.linspace(0.0, 10.0, 21)
    found = simulate(system, CHAOTIC, grid, method, tol, u=DRIVES[drive])
    exact = simulate(system, CHAOTIC, grid, "DOP853", 2.5e-14, u=DRIVES[drive], error_estimate=False)
    true = Measure.of(system, np.hstack([exact.q, exact.v]))(np.hstack([found.q - exact.q, found.v - exact.v]))
    seen = true > 1e-12
    assert seen.sum() > 10 and found.error is not None
    ratio = found.error[seen] / true[seen]
    assert 0.1 < ratio.min() and ratio.max() < 100


def test_a_law_that_samples_is_not_asked_again() -> None:
    asked: list[float] = []

    def law(t: float, x: np.ndarray) -> np.ndarray:
        asked.append(t)
        return np.zeros(2)

    run = simulate(pair(actuated="all"), CHAOTIC, [0.0, 1.0], u=law, sample=0.25)
    assert asked == [0.0, 0.25, 0.5, 0.75] and run.error is None and np.isnan(run.holds_until)
    table = simulate(pair(actuated="all"), CHAOTIC, [0.0, 1.0], u=DRIVES["line"], sample=0.25)
    assert table.error is not None


def test_a_law_that_fails_where_only_the_second_run_goes_costs_the_estimate_alone() -> None:
    known: set[float] = set()

    def law(t: float, x: np.ndarray) -> np.ndarray:
        if known and t not in known:
            raise ZeroDivisionError("never here before")
        return np.array([np.sin(t), 0.0])

    system = pair(actuated="all")
    first = simulate(system, CHAOTIC, [0.0, 1.0], "DOP853", 1e-6, u=lambda t, x: (known.add(t), law(t, x))[1], error_estimate=False)
    run = simulate(system, CHAOTIC, [0.0, 1.0], "DOP853", 1e-6, u=law)
    assert run.error is None and np.array_equal(run.q, first.q)


def test_events_beyond_the_horizon_are_marked_and_stay_so_on_file(tmp_path: Path_) -> None:
    start = np.append(np.deg2rad([120.0, -10.0]), [0.0, 0.0])
    low = Event("low", lambda t, x: x[0] + x[2])
    run = simulate(pair("absolute"), start, [0.0, 40.0], events=low)
    beyond = [crossing.t > run.holds_until for crossing in run.events]
    assert [crossing.doubtful for crossing in run.events] == beyond and set(beyond) == {True, False}
    again = Trajectory.from_npz(run.to_npz(tmp_path / "run.npz"))
    assert [crossing.doubtful for crossing in again.events] == beyond
    assert np.array_equal(again.error, run.error) and again.holds_until == run.holds_until
    assert f"holds until t = {run.holds_until:g} s" in str(run)


def test_a_terminal_event_beyond_the_horizon_is_said() -> None:
    start = np.append(np.deg2rad([120.0, -10.0]), [0.0, 0.0])
    late = Event("late", lambda t, x: t - 35.0, terminal=True)
    run = simulate(pair("absolute"), start, [0.0, 40.0], events=late)
    assert run.status == "event" and run.events[-1].doubtful and "doubtful: its estimated error" in run.reason


def test_outputs_far_apart_do_not_hide_a_horizon() -> None:
    """Between outputs that errors outgrow the tangent over, the neighbour follows the steps that were taken."""
    start = np.append(np.deg2rad([120.0, -10.0]), [0.0, 0.0])
    dense, sparse = (simulate(pair("absolute"), start, t) for t in (np.linspace(0.0, 40.0, 41), [0.0, 15.0, 25.0, 40.0]))
    assert sparse.status == dense.status == "doubtful" and sparse.holds_until == 25.0
    assert 0.05 < sparse.error[1] / dense.error[15] < 20 and 0.05 < sparse.error[2] / dense.error[25] < 20


def test_backwards_is_estimated_as_forwards() -> None:
    start = np.append(np.deg2rad([120.0, -10.0]), [0.0, 0.0])
    for method, tol in (("auto", None), ("DOP853", 1e-9)):
        there, back = (simulate(pair("absolute"), start, np.linspace(0.0, t, 41), method, tol) for t in (40.0, -40.0))
        assert back.status == there.status == "doubtful" and -40.0 < back.holds_until < -5.0
        assert 0.01 < np.median(back.error[5:20] / there.error[5:20]) < 100  # at rest at the start, so both motions are one


def test_backwards_events_beyond_lie_before_the_horizon() -> None:
    start = np.append(np.deg2rad([120.0, -10.0]), [0.0, 0.0])
    run = simulate(pair("absolute"), start, [0.0, -40.0], events=Event("low", lambda t, x: x[0] + x[2]))
    assert [crossing.doubtful for crossing in run.events] == [crossing.t < run.holds_until for crossing in run.events]
    assert run.events[-1].doubtful and not run.events[0].doubtful


def test_a_fixed_step_is_held_against_half_of_it() -> None:
    """Order 4: the half step leaves a sixteenth of the error."""
    scene = scene_from_dict({"name": "halved", "chain": {"links": 1, "mass": 1.0, "length": 1.0}, "functions": {"want": ["forward_dynamics", "step"]}})
    system, times = build(scene), np.linspace(0.0, 5.0, 6)
    exact = simulate(system, [1.0, 0.0], times, "DOP853", 1e-13)
    for h, status in ((0.02, "complete"), (0.25, "doubtful")):
        run = simulate(system, [1.0, 0.0], times, "step", h=h)
        off = np.maximum(np.abs(run.q - exact.q)[:, 0], np.abs(run.v - exact.v)[:, 0] / np.max(np.abs(run.v)))[1:]
        assert np.all((run.error[1:] > off) & (run.error[1:] < 4 * off)) and run.status == status


def test_a_chain_that_springs_faster_than_a_fixed_step_follows_is_doubted() -> None:
    """The joints swing at some 2000 rad/s: a step of classical Runge-Kutta takes their energy, and BDF does as well."""
    sprung, start = pair(stiffness=1e6), np.array([0.002, 0.001, 0.0, 0.0])
    for method, tol, h in (("step", None, 2.5e-4), ("BDF", 1e-5, None), ("cvodes", 1e-5, None)):
        run = simulate(sprung, start, [0.0, 0.25], method, tol, h=h)
        assert run.energy_drift > 1e-5 and run.status == "doubtful", method
        assert run.error[-1] > 1e-3
    assert simulate(sprung, start, [0.0, 0.25]).status == "complete"


def test_auto_is_complete_only_within_four_times_its_tolerance() -> None:
    calm = np.array([0.3, 0.1, 0.0, 0.0])
    for tol in (1e-4, 1e-6, 1e-8):
        for system, end in ((pair(), 20.0), (pair(stiffness=1e8, damping=1e6), 0.5)):
            run = simulate(system, calm, [0.0, end], tol=tol)
            exact = simulate(system, calm, run.t if len(run.t) > 2 else [0.0, end / 2, end], tol=tol / 1e4, error_estimate=False)
            off = np.max(np.abs(run.x[-1] - exact.x[-1]))
            assert run.status == "doubtful" or off <= 4 * tol


def test_without_the_taylor_flow_a_method_is_held_against_itself() -> None:
    table = {"name": "bare", "chain": {"links": 2, "mass": 1.0, "length": 1.0}}
    system = build(scene_from_dict({**table, "functions": {"want": ["forward_dynamics", "state_jacobian"]}}))
    start, times = [1.2, 0.4, 0.0, 0.0], np.linspace(0.0, 5.0, 11)
    exact = simulate(system, start, times, "DOP853", 2.3e-14, error_estimate=False)
    for method, tol in (("DOP853", 1e-6), ("RK45", 1e-5), ("Radau", 1e-6), ("DOP853", 3e-14)):
        run, plain = (simulate(system, start, times, method, tol, error_estimate=wanted) for wanted in (True, False))
        off = np.max(np.abs(run.q - exact.q), axis=1)[1:]
        assert np.all(run.error[1:] >= 0.1 * off) and (tol < 1e-13 or np.all(run.error[1:] <= 1000 * off))
        assert run.counts == plain.counts and np.array_equal(run.x, plain.x)


def test_no_estimate_is_made_where_none_is_wanted() -> None:
    run = simulate(pair(), CHAOTIC, [0.0, 60.0], error_estimate=False)
    assert run.error is None and np.isnan(run.holds_until) and run.status == "complete"


def _problem(system: System, x0: np.ndarray, t: float, tol: float) -> Problem:
    field, jacobian, control, held = bind(system, None, None, 0.0, x0)
    t_end = np.array([0.0, t])
    return Problem(system, field, jacobian, control, held, None, x0, t_end, tol, tol / 100, None, (), 10_000, None)


def _path(run: Trajectory) -> Path:
    return Path(run.t, np.hstack([run.q, run.v]), "complete", "", (), run.counts["steps"], None)
