"""What a run computes when it is read: at once the states, later the same numbers as ever."""

from __future__ import annotations

import copy
import pickle
import warnings
from functools import cache

import numpy as np
import pytest

from phichain.motion import finished, simulate
from phichain.motion.balance import Account
from phichain.motion.error import neighbours
from phichain.motion.problem import Problem
from phichain.motion.trajectory import Trajectory
from phichain.pipeline import build
from phichain.scene import Scene
from phichain.system import System, Vector

START = np.array([0.4, 0.2, 0.0, 0.0])
WAITING = {"a", "kinetic", "work", "error", "status", "reason", "holds_until", "lengths", "events"}
WANT = ("forward_dynamics", "energy", "propagate")


@cache
def pair() -> System:
    return build(Scene("read_later", 2, mass="runtime", length=1.0, damping=0.1, actuated="all", want=WANT))


def run(**more: object) -> Trajectory:
    return simulate(pair(), START, [0.0, 2.0], p={"mass": np.ones(2)}, **more)


def test_the_second_run_waits_for_a_reader(monkeypatch: pytest.MonkeyPatch) -> None:
    made = []
    real = finished.estimated
    monkeypatch.setattr(finished, "estimated", lambda *given: made.append(1) or real(*given))
    found = run()
    assert not made and not WAITING & vars(found).keys()
    assert found.t[-1] == 2.0 and found.x.shape == (len(found.t), 4) and not made
    assert found.status == "complete" and len(made) == 1
    assert found.error is not None and found.holds_until == 2.0 and found.resample(5).status == "complete" and len(made) == 1
    assert not found.error.flags.writeable and not found.a.flags.writeable and not found.q.flags.writeable


@pytest.mark.parametrize("copied", [copy.copy, copy.deepcopy, lambda run: pickle.loads(pickle.dumps(run))])
def test_a_copy_has_what_was_never_read(copied: object) -> None:
    found, plain = copied(run()), run()
    for name in ("a", "kinetic", "work", "loss", "error", "lengths"):
        assert np.array_equal(getattr(found, name), getattr(plain, name)), name
    assert (found.status, found.reason, found.holds_until) == (plain.status, plain.reason, plain.holds_until)


def test_what_a_caller_changes_later_changes_nothing() -> None:
    p, x0, expected = {"mass": np.ones(2)}, START.copy(), run().settle()
    found = simulate(pair(), x0, [0.0, 2.0], p=p)
    p["mass"][:] = 7.0
    x0[:] = 0.0
    assert np.array_equal(found.kinetic, expected.kinetic) and np.array_equal(found.a, expected.a) and np.array_equal(found.error, expected.error)


def test_a_law_is_asked_before_simulate_returns() -> None:
    asked: list[float] = []

    def law(t: float, x: Vector) -> Vector:
        asked.append(t)
        return np.array([0.1 * np.sin(t), 0.0])

    found, count = run(u=law, method="DOP853"), len(asked)
    assert {"status", "u", "a"} <= vars(found).keys()
    assert found.status == "complete" and found.u is not None and found.work is not None and len(asked) == count


def test_an_unknown_field_is_no_field() -> None:
    with pytest.raises(AttributeError, match="has no attribute 'wrok'"):
        run().wrok  # noqa: B018


def test_errors_that_have_died_out_are_those_of_the_steps_since(monkeypatch: pytest.MonkeyPatch) -> None:
    """A neighbour that comes to rest where the path does is no distance away: 0 / 0 was its direction."""
    real = neighbours.flown

    def settled(problem: Problem, t: Vector, x: Vector, tol: float, budget: int) -> Vector:
        states = real(problem, t, x, tol, budget)
        away = np.argmin(np.abs(path.t[:, None] - t[1:]), axis=0)
        return np.where((t[1:] > 1.0)[:, None], path.x[away], states)

    monkeypatch.setattr(neighbours, "flown", settled)
    path = run()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert path.error is not None and np.isfinite(path.error).all() and 0 < path.error[-1] < 1e-12


def test_a_step_too_short_for_the_clock_is_booked_as_over() -> None:
    account = Account(pair(), {"mass": np.ones(2)})
    for knots in ([0.0, 1.0], [1.0, 2.0], [2.0, 2.0]):
        times = account.points(np.array(knots), 5)
        account.book(np.array(knots), 5, np.tile([0.0, 0.0, 1.0, 1.0], (len(times), 1)), np.array([1.0, 0.0]))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        work, loss = account.at(np.array([0.0, 0.5, 1.0, 1.5, 2.0]))
    np.testing.assert_allclose(work, [0.0, 0.5, 1.0, 1.5, 2.0], rtol=1e-14, atol=1e-14)
    np.testing.assert_allclose(loss, 0.2 * work, rtol=1e-13, atol=1e-15)  # both joints turn at 1 rad/s
