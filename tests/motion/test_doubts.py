"""Beside a separatrix: what a run cannot vouch for it says; what it can, it does."""

from __future__ import annotations

from functools import cache
from itertools import product
from math import inf, nextafter, pi
from typing import Any

import numpy as np
import pytest

from phichain.motion import doubts, simulate
from phichain.motion.problem import Problem, bind
from phichain.pipeline import build
from phichain.scene import scene_from_dict
from phichain.system import System, pack
from phichain.system.angles import absolute_angles
from phichain.system.vertical import configuration


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
    assert simulate(pendulum(), np.array([0.0, rate]), [0.0, 20.0]).status == "complete"


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


@cache
def chain(space: str, angles: str | None = None) -> System:
    """Four unequal links."""
    table: dict[str, Any] = {"links": 4, "space": space, "mass": [1.0, 0.3, 2.0, 0.7], "length": [0.5, 1.0, 0.25, 0.8]}
    joints = {"joints": {"angles": angles}} if angles else {}
    want = {"want": ["forward_dynamics", "energy", "propagate"]}
    return build(scene_from_dict({"name": f"doubts4{space}{angles}", "chain": table, "functions": want, **joints}))


CHAINS = [("planar", "relative"), ("planar", "absolute"), ("spatial", None)]


def problem(system: System, x0: np.ndarray) -> Problem:
    field, jacobian, control, held = bind(system, None, None, 0.0, x0)
    return Problem(system, field, jacobian, control, held, None, x0, np.array([0.0, 1.0]), 1e-9, 1e-11, None, (), 10, None)


def every_upright(system: System) -> list[tuple[int, ...]]:
    return [s for s in product((1, -1), repeat=system.links) if -1 in s]


@pytest.mark.long
@pytest.mark.parametrize(("space", "angles"), CHAINS)
def test_the_energies_of_all_equilibria_follow_from_those_of_n_plus_1(space: str, angles: str | None) -> None:
    system = chain(space, angles)
    states = np.array([configuration(system, s) for s in every_upright(system)])
    exact = sum(system.energy(states, np.zeros((len(states), system.nv))))
    found = doubts._levels(problem(system, np.zeros(system.nx)))
    np.testing.assert_allclose(np.sort(found), np.sort(exact), rtol=0, atol=1e-13)


def lean(system: System, x: np.ndarray, s: tuple[int, ...]) -> float:
    """Largest lean from one equilibrium, or rate; infinite beyond a right angle."""
    q, v = x[: system.nq], x[system.nq :]
    if system.is_planar:
        phi = absolute_angles(system, q)
        links = np.stack([np.sin(phi), 0 * phi, np.cos(phi)], axis=1)
    else:
        links = q.reshape(-1, 3)
    leans = [np.hypot(x, y) if z * sign > 0 else inf for (x, y, z), sign in zip(links, s, strict=True)]
    return float(max(*leans, *np.abs(v)))


@pytest.mark.parametrize(("space", "angles"), CHAINS)
def test_the_one_equilibrium_that_is_near_is_the_nearest_of_all(space: str, angles: str | None) -> None:
    system, random = chain(space, angles), np.random.default_rng(7)
    seen = set()
    for s in product((1, -1), repeat=4):
        for size in (0.0, 1e-13, 0.3):
            q, v = configuration(system, s) + size * random.normal(size=system.nq), size * random.normal(size=system.nv)
            x = pack(q, v)
            nearest = min(lean(system, x, other) for other in every_upright(system))
            seen.add(nearest == inf)
            assert doubts._distance(system, x) == pytest.approx(nearest, rel=1e-12, abs=0)
    assert seen == {True, False}


def test_no_equilibria_are_built_but_a_row_per_link_where_energy_drifts(monkeypatch: pytest.MonkeyPatch) -> None:
    built: list[tuple[int, ...]] = []

    def counted(system: System, s: tuple[int, ...]) -> np.ndarray:
        built.append(s)
        return configuration(system, s)

    monkeypatch.setattr(doubts, "configuration", counted)
    start = np.array([0.3, -0.2, 0.1, 0.4, 0, 0, 0, 0])
    simulate(chain("planar", "relative"), start, [0.0, 3.0]).settle()
    assert not built
    assert simulate(chain("planar", "relative"), start, [0.0, 3.0], "RK45", 1e-4).settle().energy_drift > 1e-9
    assert len(built) == 5
