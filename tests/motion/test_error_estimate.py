"""A run that did not keep what was asked says so: chaos, noise, and methods that lose count."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from phichain.motion import METHODS, simulate
from phichain.motion.error import NONE, estimated
from phichain.motion.path import Path
from phichain.motion.problem import Problem, bind
from phichain.motion.trajectory import Trajectory
from phichain.pipeline import build
from phichain.scene import scene_from_dict
from phichain.system import System


@cache
def pair(angles: str = "relative", com: float = 1.0, **joints: float) -> System:
    chain = {"links": 2, "mass": 1.0, "length": 1.0, "gravity": 9.8, "com": com}
    want = {"want": ["forward_dynamics", "energy", "state_jacobian", "propagate", "propagate_stiff"]}
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
    assert simulate(pair("absolute"), start, [0.0, 5.0]).status == "complete"


def test_motions_that_keep_what_was_asked_are_not_doubted() -> None:
    calm = np.array([0.3, 0.1, 0.0, 0.0])
    for method, tol in (("auto", None), ("auto", 1e-9), ("auto", 1e-6), ("DOP853", 1e-9), ("BDF", 1e-6)):
        assert simulate(pair(), calm, [0.0, 10.0], method, tol).status == "complete"
    damped = pair(stiffness=1e8, damping=1e6)
    run = simulate(damped, calm, [0.0, 10.0], tol=1e-9)
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


def test_inputs_that_move_have_no_estimate() -> None:
    problem = replace(_problem(pair(), CHAOTIC, 1.0, 1e-9), control=lambda t, x: np.zeros(0))
    path = _path(simulate(pair(), CHAOTIC, [0.0, 1.0]))
    off = replace(path, x=path.x + 1.0)
    assert estimated(problem, off, "DOP853", METHODS["DOP853"], None) is NONE


def _problem(system: System, x0: np.ndarray, t: float, tol: float) -> Problem:
    field, jacobian, control, held = bind(system, None, None, 0.0, x0)
    t_end = np.array([0.0, t])
    return Problem(system, field, jacobian, control, held, None, x0, t_end, tol, tol / 100, None, (), 10_000, None)


def _path(run: Trajectory) -> Path:
    return Path(run.t, np.hstack([run.q, run.v]), "complete", "", (), run.counts["steps"], None)
