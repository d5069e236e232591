"""Stiff springs in absolute and adjacent angles: as good as in joint angles, because joint angles are carried inside."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from functools import cache
from typing import Any

import numpy as np
import pytest
from mpmath import mp

from phichain.emit.flow.propagate_stiff import stiff
from phichain.ir.interpret import run
from phichain.ir.rounded import arithmetic
from phichain.lowering.planar.joint_state import from_joints, to_joint_inputs, to_joints
from phichain.mechanics import derive
from phichain.motion import simulate
from phichain.pipeline import build
from phichain.scene import Scene, scene_from_dict
from phichain.system import System
from tests.stiff.test_stiff_flow import RIGID

KINDS = ("absolute", "adjacent")


def scene(name: str, angles: str, joints: dict[str, Any], links: int = 3, **more: Any) -> Scene:
    table = {"links": links, "mass": 1.0, "length": 1.0, "gravity": 9.81, **more}
    want = {"want": ["forward_dynamics", "propagate", "propagate_stiff"]}
    return scene_from_dict(
        {"name": name, "chain": table, "functions": want, "joints": {"angles": angles, **joints}}
    )


@cache
def system(angles: str, kind: str, links: int = 3) -> System:
    """Joints near critical damping at some 1e7 rad/s, or undamped springs of a million times the weight."""
    free = [0.0] + [1.0] * (links - 1)
    joints = {"stiff": {"stiffness": [1e13 * x for x in free], "damping": [3e6 * x for x in free]},
              "sprung": {"stiffness": [9.81e6 * x for x in free]}}[kind]  # fmt: skip
    return build(scene(f"{kind}_{angles}{links}", angles, joints, links))


def own(angles: str, phi: np.ndarray) -> np.ndarray:
    """Angles of a kind from those of the links; exact for the numbers used here."""
    if angles == "absolute":
        return phi
    if angles == "relative":
        return np.diff(phi, prepend=0.0)
    theta = phi.copy()
    for k in range(1, len(phi)):
        theta[k] -= theta[k - 1]
    return theta


def of_links(angles: str, theta: np.ndarray) -> np.ndarray:
    """And back."""
    return {"absolute": theta, "relative": np.cumsum(theta), "adjacent": theta + np.append(0.0, theta[:-1])}[
        angles
    ]


def linear(links: int, stiffness: float, damping: float, phi: list[Any], t: float) -> np.ndarray:
    """Small motions of equal links of 1 kg and 1 m: the exponential of the linear equations, in 60 digits."""
    with mp.workdps(60):
        mass = mp.matrix(links, links)
        pull, drag = mp.matrix(links, links), mp.matrix(links, links)
        for i in range(links):
            pull[i, i] = mp.mpf(9.81) * (links - i)
            for j in range(links):
                mass[i, j] = links - max(i, j)
        for j in range(1, links):
            for matrix, value in ((pull, mp.mpf(stiffness)), (drag, mp.mpf(damping))):
                for a, b, sign in ((j, j, 1), (j - 1, j - 1, 1), (j, j - 1, -1), (j - 1, j, -1)):
                    matrix[a, b] += sign * value
        slope = mp.matrix(2 * links, 2 * links)
        by_angle, by_rate = mass**-1 * pull, mass**-1 * drag
        for i in range(links):
            slope[i, links + i] = 1
            for j in range(links):
                slope[links + i, j], slope[links + i, links + j] = -by_angle[i, j], -by_rate[i, j]
        values, vectors = mp.eig(slope)
        weights = mp.lu_solve(vectors, mp.matrix([*map(mp.mpf, phi), *([0] * links)]))
        end = vectors * mp.matrix(
            [w * mp.exp(value * mp.mpf(t)) for w, value in zip(weights, values, strict=True)]
        )
        return np.array([float(mp.re(x)) for x in end])


@pytest.mark.long
@pytest.mark.parametrize("angles", KINDS)
def test_small_motions_of_damped_joints_follow_the_tolerance(angles: str) -> None:
    phi = np.array([1.0, 1.0 + 2.0**-10, 1.0 - 2.0**-11]) * 2.0**-30
    expected, start = linear(3, 1e13, 3e6, list(phi), 1.0), own(angles, phi)
    errors = []
    for tol in (1e-6, 1e-9, 1e-12):
        found = system(angles, "stiff").propagate_stiff(start, np.zeros(3), 0.0, 1.0, tol, max_steps=20_000)
        assert found.outcome == "done"
        end = np.concatenate([of_links(angles, found.q), of_links(angles, found.v)])
        errors.append(np.max(np.abs(end - expected)) / np.max(np.abs(expected)))
    assert errors[0] < 1e-6 and errors[1] < 1e-10 and errors[2] < 3e-13


def test_slow_motions_keep_time() -> None:
    """By the published decimals of the method 17 s end 4e-13 away, whatever the tolerance."""
    phi = np.ones(3) * 2.0**-30
    expected = linear(3, 1e13, 3e6, list(phi), 17.0)
    found = system("absolute", "stiff").propagate_stiff(phi, np.zeros(3), 0.0, 17.0, 1e-13, max_steps=20_000)
    assert np.max(np.abs(np.concatenate([found.q, found.v]) - expected)) < 5e-15 * np.max(np.abs(expected))


@pytest.mark.parametrize("angles", KINDS)
def test_the_joint_of_1e13_newton_metres_from_one_radian(angles: str) -> None:
    """Case B10 but for what 1 + 1e-3 rounds to: what the joint keeps of it dies within microseconds."""
    phi = np.array([1.0, 1.0 + 1e-3])
    run = simulate(
        system(angles, "stiff", 2), np.append(own(angles, phi), np.zeros(2)), [0.0, 5.0], "rosenbrock", 1e-12
    )
    expected = np.cumsum(np.array(RIGID["reference"]["5.0"], dtype=float).reshape(2, 2), axis=1).ravel()
    end = np.concatenate([of_links(angles, run.q[-1]), of_links(angles, run.v[-1])])
    assert run.status == "complete"
    assert np.max(np.abs(end - expected)) < 3e-12


@pytest.mark.parametrize("angles", KINDS)
def test_a_cut_run_and_states_on_the_way(angles: str) -> None:
    """What rounding took is handed on in the scene's own angles; a state on the way is the end of a run to there."""
    flow, start = system(angles, "stiff").propagate_stiff, own(angles, np.array([1.0, 1.0 + 2.0**-10, 1.0]))
    whole = flow(start, np.zeros(3), 0.0, 1.0, 1e-10, times=[0.25])
    some = flow(start, np.zeros(3), 0.0, 1.0, 1e-10, max_steps=300)
    rest = flow(some.q, some.v, some.t, 1.0, 1e-10, lost=some.lost, memory=some.memory)
    assert some.outcome == "step budget" and some.steps + rest.steps == whole.steps
    assert np.max(np.abs(rest.q - whole.q)) < 1e-15 and np.max(np.abs(rest.v - whole.v)) < 1e-13
    alone = flow(start, np.zeros(3), 0.0, 0.25, 1e-10)
    assert np.max(np.abs(whole.q_at[0] - alone.q)) < 1e-11


@pytest.mark.long
@pytest.mark.parametrize("angles", KINDS)
@pytest.mark.parametrize("links", [2, 3])
def test_undamped_springs_a_million_times_the_weight(angles: str, links: int) -> None:
    """A straight chain let go at one radian: the Taylor flow in these angles against the one in joint angles."""
    ends = []
    for kind in ("relative", angles):
        found = system(kind, "sprung", links).propagate(
            own(kind, np.ones(links)), np.zeros(links), 0.0, 1.0, 2.0**-52
        )
        ends.append(np.concatenate([of_links(kind, found.q), of_links(kind, found.v)]))
    assert np.max(np.abs(ends[1] - ends[0])) < 3e-13


@pytest.mark.long
@pytest.mark.parametrize("angles", KINDS)
@pytest.mark.parametrize("base", ["fixed", "cart"])
def test_inputs_reach_the_joints(angles: str, base: str) -> None:
    """The implicit flow with torques on the angles against the Taylor flow, which takes them as they are."""
    cart = {"base": "cart", "cart_mass": 1.0} if base == "cart" else {}
    joints = {"stiffness": [1.0, 20.0, 30.0], "damping": 0.5, "actuated": "all"}
    chain = build(scene(f"driven_{angles}_{base}", angles, joints, 3, **cart))
    rng = np.random.default_rng(4)
    q, v, u = rng.normal(size=chain.nq), rng.normal(size=chain.nv), rng.normal(size=chain.nu)
    ends = [flow(q, v, 0.0, 0.5, 1e-11, u=u) for flow in (chain.propagate, chain.propagate_stiff)]
    assert np.max(np.abs(ends[0].q - ends[1].q)) < 1e-9 and np.max(np.abs(ends[0].v - ends[1].v)) < 1e-9


@pytest.mark.parametrize("angles", KINDS)
@pytest.mark.parametrize("base", ["fixed", "cart"])
def test_there_and_back_loses_the_square_of_the_round_off(angles: str, base: str) -> None:
    cart = {"base": "cart", "cart_mass": 1.0} if base == "cart" else {}
    chain = scene("turned", angles, {"stiffness": 1e3}, 4, **cart)
    rng = np.random.default_rng(6)
    size = 4 + (base == "cart")
    state = {
        name: (10.0 ** rng.uniform(-6, 3, size) * rng.choice([-1, 1], size)).tolist() for name in ("q", "v")
    }
    state["lost"] = [x * 2.0**-54 * rng.uniform(-1, 1) for x in state["q"] + state["v"]]
    doubles = arithmetic("double")
    joints = run(to_joints(chain), doubles, state)
    for part, first in (("q", 0), ("v", size)):
        exact = [Fraction(x) + Fraction(e) for x, e in zip(state[part], state["lost"][first:], strict=False)]
        found = [
            Fraction(x) + Fraction(e)
            for x, e in zip(joints[f"{part}_made"], joints["lost_made"][first:], strict=False)
        ]
        lag, carts = (1 if angles == "absolute" else 2), size - 4
        for k in range(size):
            before = exact[k - lag] if k >= carts + lag else 0
            largest = max(abs(exact[k]), abs(before))
            assert abs(found[k] - (exact[k] - before)) <= largest * Fraction(1, 2**104)
    again = {"q": joints["q_made"], "v": joints["v_made"], "lost": joints["lost_made"]}
    back = run(from_joints(chain), doubles, again)
    assert list(back["q_made"]) == state["q"] and list(back["v_made"]) == state["v"]


def test_torques_at_joints_do_the_work_of_those_on_angles() -> None:
    """tau . theta = tau_joint . joint for every theta."""
    doubles = arithmetic("double")
    for angles in KINDS:
        chain = scene("work", angles, {"stiffness": 1.0, "actuated": "all"}, 4)
        made = run(to_joint_inputs(chain), doubles, {"u": [3.0, 5.0, -7.0, 11.0]})["joint_u"]
        phi = np.array([1.0, -2.0, 4.0, 0.5])
        theta = own(angles, phi)
        assert float(np.dot([3.0, 5.0, -7.0, 11.0], theta)) == float(np.dot(made, own("relative", phi)))


@pytest.mark.parametrize("angles", KINDS)
def test_a_scene_that_carries_derivatives_along_has_its_implicit_flow(angles: str) -> None:
    """The chain in joint angles is asked for its dynamics alone, whatever the scene's own flows carry."""
    sprung = scene(f"carried_{angles}", angles, {"stiffness": 1.0, "damping": 0.1})
    with_columns = stiff(derive(replace(sprung, variational=True)))
    assert with_columns == stiff(derive(sprung))
