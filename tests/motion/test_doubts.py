"""Beside a separatrix: what a run cannot vouch for it says; what it can, it does."""

from __future__ import annotations

from functools import cache
from math import nextafter, pi

import numpy as np
import pytest

from phichain.motion import simulate
from phichain.pipeline import build
from phichain.scene import scene_from_dict
from phichain.system import System


@cache
def pendulum() -> System:
    table = {"name": "doubts1", "chain": {"links": 1, "mass": 1.0, "length": 1.0}}
    return build(
        scene_from_dict(
            table | {"functions": {"want": ["forward_dynamics", "energy", "state_jacobian", "propagate"]}}
        )
    )


@cache
def spherical() -> System:
    table = {"name": "doubts1s", "chain": {"links": 1, "mass": 1.0, "length": 1.0, "space": "spatial"}}
    return build(scene_from_dict(table | {"functions": {"want": ["forward_dynamics", "energy"]}}))


@pytest.mark.parametrize("method", ["DOP853", "Radau", "LSODA"])
def test_a_start_that_plain_sums_cannot_tell_from_the_top_is_doubted(method: str) -> None:
    start = np.array([nextafter(pi, 0.0), 0.0])
    run = simulate(pendulum(), start, [0.0, 14.0], method, 1e-10)
    assert run.status == "doubtful" and "rad from an unstable equilibrium" in run.reason


def test_the_flow_leaves_the_top_on_the_right_side_and_vouches_for_it() -> None:
    """From the last double below pi the pendulum falls back: sin pi > 0 there, so theta'' < 0 and never turns over."""
    run = simulate(pendulum(), np.array([nextafter(pi, 0.0), 0.0]), [0.0, 14.0])
    assert run.status == "complete" and np.all(run.q <= pi) and np.min(run.q) < 0


def test_energy_lost_across_a_separatrix_is_doubted() -> None:
    """1e-9 J below the top's energy, a loose tolerance cannot say whether the top is passed."""
    rate = np.sqrt(4 * 9.81 - 2e-9)
    loose, tight = (
        simulate(pendulum(), np.array([0.0, rate]), [0.0, 30.0], "DOP853", tol) for tol in (1e-6, 1e-13)
    )
    assert loose.status == "doubtful" and "an unstable equilibrium's is 1e-09 J away" in loose.reason
    assert "which side of it the motion takes is not known" in loose.reason
    assert tight.status == "doubtful" and "puts the motion's phase off by" in tight.reason
    assert simulate(pendulum(), np.array([0.0, rate]), [0.0, 30.0]).status == "complete"


def test_a_unit_vector_beside_the_upper_pole_is_doubted() -> None:
    away = 1e-14
    run = simulate(spherical(), np.array([away, 0.0, -1.0, 0.0, 0.0, 0.0]), [0.0, 2.0], "DOP853", 1e-10)
    assert run.status == "doubtful"


def test_ordinary_runs_are_not_doubted() -> None:
    assert simulate(pendulum(), np.array([0.4, 0.0]), [0.0, 10.0], "RK45", 1e-4).status == "complete"
    assert (
        simulate(spherical(), np.array([0.6, 0.0, 0.8, 0.0, 0.3, 0.0]), [0.0, 2.0], "DOP853").status
        == "complete"
    )
    at_rest = simulate(pendulum(), np.array([0.0, 0.0]), [0.0, 2.0], "DOP853")
    assert at_rest.status == "complete"
