"""The books of a run: E - E(0) - work + loss, with work and loss judged by quadratures of their own."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from phichain.archive import read_archive
from phichain.motion import Table, Trajectory, balance, simulate
from phichain.motion.trajectory import _SCHEMA
from phichain.records import write_npz
from phichain.system import System
from phichain.system.power import joint_rates, powers
from tests.handmade import planar
from tests.motion.rigs import cart_pole, globe, pair, pendulum

TORQUES = Table([0.0, 0.3, 0.8, 2.0], [[0.5, 0.1], [-0.4, 0.2], [0.2, -0.3], [0.0, 0.0]])
START = np.array([0.5, -0.2, 0.0, 0.3])


def pushed(t: float, x: np.ndarray) -> np.ndarray:
    return np.array([0.3 * np.cos(3 * t) - 0.1 * x[2], 0.05 * x[1]])


@cache
def books() -> tuple[np.ndarray, np.ndarray]:
    """Work and loss of `pushed` on the damped pair over 2 s: as two further states of an ordinary differential equation."""
    system = pair(damping=0.05)

    def field(t: float, y: np.ndarray) -> np.ndarray:
        u, v = pushed(t, y[:4]), y[2:4]
        loss = 0.05 * v[0] ** 2 + 0.10 * v[1] ** 2  # relative angles: their rates are the joints'
        return np.concatenate([v, system.forward_dynamics(y[:2], v, u), [u @ v, loss]])

    grid = np.linspace(0.0, 2.0, 9)
    found = solve_ivp(field, (0.0, 2.0), [*START, 0.0, 0.0], "DOP853", grid, rtol=1e-12, atol=1e-14)
    return grid, found.y[4:]


@pytest.mark.long
@pytest.mark.parametrize(("method", "tol", "most"), [("DOP853", 1e-10, 1e-12), ("RK45", 1e-9, 1e-10), ("Radau", 1e-9, 1e-10), ("LSODA", 1e-10, 1e-9)])
def test_work_and_loss_of_a_law_on_a_damped_chain(method: str, tol: float, most: float) -> None:
    grid, (work, loss) = books()
    run = simulate(pair(damping=0.05), START, grid, method, tol, u=pushed)
    assert np.max(np.abs(run.work - work)) < most and np.max(np.abs(run.loss - loss)) < most
    assert run.balance_error < most < 1e-3 * run.loss[-1] and np.array_equal(run.balance, run.energy - run.energy[0] - run.work + run.loss)


@pytest.mark.long
@pytest.mark.parametrize("angles", ["relative", "absolute", "adjacent"])
def test_the_taylor_flow_keeps_the_balance_at_round_off(angles: str) -> None:
    for outputs in ([0.0, 2.0], np.linspace(0.0, 2.0, 7), np.linspace(0.4, 0.1, 4)):
        for events in (None, lambda t, x: x[0]):
            run = simulate(pair(angles, 0.05), START, outputs, u=TORQUES, events=events)
            assert run.method == "taylor"
            # Backwards the damper's 51 J are gained: their last place is 7e-15.
            assert run.balance_error < 2e-15 * max(1.0, abs(run.loss[-1])) and run.energy_drift > 1e-2 and abs(run.loss[-1]) > 1e-3
            assert run.work[0] == run.loss[0] == 0.0


def test_books_do_not_depend_on_the_outputs() -> None:
    own = simulate(pair(damping=0.05), START, [0.0, 2.0], u=TORQUES)
    grid = np.linspace(0.0, 2.0, 33)
    direct = simulate(pair(damping=0.05), START, grid, u=TORQUES)
    again = own.resample(grid)
    assert np.max(np.abs(again.work - direct.work)) < 1e-14 and np.max(np.abs(again.loss - direct.loss)) < 1e-14
    assert again.balance_error < 3e-14


def test_books_are_kept_step_by_step_whatever_is_asked_on_the_way() -> None:
    """As many outputs as steps, all in the last tenth: what was passed is not what was stepped."""
    steps = simulate(pair(damping=0.05), START, [0.0, 1.0], "taylor", u=[0.3, 0.1]).counts["steps"]
    late = np.concatenate([[0.0], np.linspace(0.9, 1.0, steps)])
    assert simulate(pair(damping=0.05), START, late, "taylor", u=[0.3, 0.1]).balance_error < 1e-14


def test_a_damped_chain_in_space_on_a_pushed_cart() -> None:
    q = np.array([0.0, 0.0, 0.6, 0.0, 0.8, 0.0, 0.6, 0.8])
    v = np.array([0.1, 0.2, 0.0, 1.0, 0.0, 0.5, 0.0, 0.0])
    run = simulate(globe(), (q, v), [0.0, 2.0], u=Table([0.0, 1.0, 2.0], [[0.3, -0.2], [-0.5, 0.4], [0.0, 0.0]]))
    assert run.method == "taylor" and run.balance_error < 1e-13 and run.loss[-1] > 0.02
    smooth = simulate(globe(), (q, v), [0.0, 2.0], tol=1e-10, u=lambda t, x: [0.3 * np.sin(t), -x[9]])
    assert smooth.method == "DOP853" and smooth.balance_error < 1e-8 and np.all(np.diff(smooth.loss) > 0)


def test_stiff_flows_keep_their_balance() -> None:
    stiff = pair(damping=0.05)
    for outputs in ([0.0, 2.0], np.linspace(0.0, 2.0, 5)):
        run = simulate(stiff, START, outputs, "rosenbrock", 1e-9, u=TORQUES)
        assert run.balance_error < 1e-8


def test_sundials_keeps_the_balance_as_far_as_its_outputs_are_close() -> None:
    pytest.importorskip("casadi")
    run = simulate(pair(damping=0.05), START, np.linspace(0.0, 2.0, 401), "cvodes", 1e-10, u=TORQUES)
    assert run.balance_error < 1e-6


def test_a_fixed_step_books_the_input_that_it_held() -> None:
    """u(t, x) held over each step of 1e-2 s: with the law itself the books would be off by 1e-3."""
    run = simulate(cart_pole(), [0.0, 0.5, 0.0, 0.0], [0.0, 2.0], "step", h=1e-2, u=lambda t, x: [np.sin(9 * t)])
    assert run.balance_error < 2e-7
    force, x = np.sin(9 * run.t), run.q[:, 0]
    assert run.work[-1] == pytest.approx(np.sum(force[:-1] * np.diff(x)), abs=1e-7)


def test_a_constant_torque_works_by_the_angle_it_turns() -> None:
    run = simulate(pendulum(), [0.4, 0.0], [0.0, 3.0], u=[2.0])
    assert np.max(np.abs(run.work - 2.0 * (run.q[:, 0] - 0.4))) < 1e-13 and np.all(run.loss == 0.0)


def test_nothing_is_booked_where_nothing_is_done_or_lost() -> None:
    for u in (None, [0.0]):
        run = simulate(pendulum(), [0.4, 0.0], 1.0, u=u)
        assert run.work is None and run.loss is None and "energy drift" in str(run)
        assert np.array_equal(run.balance, run.energy - run.energy[0])
    blind = simulate(planar([1.0], [1.0], actuated="all", leave_out=["energy"]), [0.4, 0], 1.0, u=[1.0])
    assert blind.work is None and blind.balance is None and np.isnan(blind.balance_error)


def test_a_run_says_its_balance_instead_of_a_drift() -> None:
    text = str(simulate(pair(damping=0.05), START, 1.0, u=TORQUES))
    assert "energy drift" not in text and "energy balance kept to" in text and "work" in text and "loss" in text


@pytest.mark.parametrize("wrong", ["no loss", "loss of absolute rates", "half the work", "work of the other joint"])
def test_a_wrong_power_shows_in_the_balance(monkeypatch: pytest.MonkeyPatch, wrong: str) -> None:
    """The balance is a check because energy, motion and powers come from three places."""

    def mutant(system: System, x: np.ndarray, u: np.ndarray, p: object) -> object:
        right = powers(system, x, u)
        v = x[:, system.nq :]
        other = {
            "no loss": {"loss": 0 * right.loss},
            "loss of absolute rates": {"loss": np.sum([0.05, 0.1] * np.cumsum(v, axis=1) ** 2, axis=1)},
            "half the work": {"work": right.work / 2},
            "work of the other joint": {"work": np.sum(u * v[:, ::-1], axis=1)},
        }
        return replace(right, **other[wrong])

    monkeypatch.setattr(balance, "powers", mutant)
    assert simulate(pair(damping=0.05), START, [0.0, 2.0], u=TORQUES).balance_error > 1e-4


def test_rates_of_joints_are_those_of_neighbours() -> None:
    v = np.array([[0.3, 0.5]])
    expected = {"relative": [0.3, 0.5], "absolute": [0.3, 0.2], "adjacent": [0.3, 0.5]}
    for angles, rates in expected.items():
        assert joint_rates(pair(angles, 0.05), v)[0].tolist() == pytest.approx(rates)


def test_books_survive_files_and_old_files_have_none(tmp_path) -> None:
    run = simulate(pair(damping=0.05), START, np.linspace(0, 1, 5), u=TORQUES)
    copy = Trajectory.from_npz(run.to_npz(tmp_path / "run.npz"))
    assert np.array_equal(copy.work, run.work) and np.array_equal(copy.loss, run.loss) and copy.energy_words == run.energy_words
    arrays, meta = read_archive(tmp_path / "run.npz", _SCHEMA)
    for name in ("work", "loss"):
        arrays.pop(name)
    old = Trajectory.from_npz(write_npz(tmp_path / "old.npz", arrays, {**meta, "kind": "Trajectory"}))
    assert old.work is None and "energy drift" in str(old)
    assert run.resample(9).work is None
