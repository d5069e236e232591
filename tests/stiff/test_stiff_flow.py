"""The compiled stiff flow: reference cases, outcomes, outputs on the way, and what it refuses."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from phichain.errors import ArrayError, ToleranceError
from phichain.scene import Scene
from phichain.system import rhs, rhs_jacobian
from tests.generated.compiling import STRICT, compiled, write_c
from tests.lowering.chains import scene
from tests.stiff.systems import spatial_start, system

CASES = json.loads((Path(__file__).parents[1] / "data" / "extreme_cases.json").read_text())["cases"]
RIGID = next(case for case in CASES if case["id"] == "B10")


def test_a_joint_of_1e13_newton_metres() -> None:
    """Case B10: 5 s to 1e-12 from a transient of microseconds on; the joint's own angle, 7e-14 rad, to 10 digits."""
    found = system("rigid_joint").propagate_stiff([1.0, 1e-3], [0.0, 0.0], 0.0, 5.0, 1e-13)
    expected = np.array(RIGID["reference"]["5.0"], dtype=float)
    assert found.outcome == "done" and found.steps < 10_000
    assert np.max(np.abs(np.append(found.q, found.v) - expected)) < 1e-12
    assert abs(found.q[1] / expected[1] - 1) < 1e-10


def test_errors_follow_the_tolerance() -> None:
    expected = np.array(RIGID["reference"]["5.0"], dtype=float)
    errors, steps = [], []
    for tol in (1e-4, 1e-6, 1e-8, 1e-10):
        found = system("rigid_joint").propagate_stiff([1.0, 1e-3], [0.0, 0.0], 0.0, 5.0, tol)
        errors.append(np.max(np.abs(np.append(found.q, found.v) - expected)) / tol)
        steps.append(found.steps)
    assert max(errors) < 2
    # Of order 5: a hundredth of the error for 100^(1/5) = 2.5 times the steps.
    assert steps[-1] / steps[0] < 2.6**3


def test_overdamped_joints_creep_for_hours() -> None:
    """d theta' = -dV/dtheta but for inertia that is over in microseconds: the first-order equation, by another method."""
    found = system("overdamped").propagate_stiff([1.0, 0.5], [0.0, 0.0], 0.0, 1e4, 1e-10)

    def creep(t: float, theta: np.ndarray) -> np.ndarray:
        one, both = 9.81 * math.sin(theta[0]), 9.81 * math.sin(theta[0] + theta[1])
        return np.array([-(2 * one + both) / 1e6, -both / 1e6])

    slow = solve_ivp(creep, (0.0, 1e4), [1.0, 0.5], method="DOP853", rtol=1e-12, atol=1e-14).y[:, -1]
    assert found.steps < 300
    # Inertia, left out there, delays the creep by microseconds of its 1e-5 rad/s.
    assert np.max(np.abs(found.q - slow)) < 3e-10


@pytest.mark.parametrize("name", ["spatial_stiff", "single_precision"])
def test_against_radau(name: str) -> None:
    pair = system(name)
    q, v = spatial_start(2, 2) if name == "spatial_stiff" else (np.array([1.0, 0.5]), np.zeros(2))
    p = {"mass": [1.0, 0.7]} if name == "spatial_stiff" else None
    tol = 1e-8 if pair.real == "double" else 1e-4
    exact = pair if pair.real == "double" else system("single_precision")
    found = pair.propagate_stiff(q, v, 0.0, 0.5, tol, p=p)
    field, slope = rhs(exact), rhs_jacobian(exact)
    floor = 1e-10 if pair.real == "double" else 1e-6
    radau = solve_ivp(
        lambda t, x: field(t, x, p=p), (0.0, 0.5), np.append(q, v), method="Radau", rtol=floor, atol=floor,
        jac=lambda t, x: slope(t, x, p=p),
    )  # fmt: skip
    assert np.max(np.abs(np.append(found.q, found.v) - radau.y[:, -1])) < 20 * tol


def test_states_on_the_way_and_pieces() -> None:
    """A state on the way is as good as the end; a run that is cut and goes on takes the same steps."""
    pair, start = system("rigid_joint"), ([1.0, 1e-3], [0.0, 0.0])
    times = [1e-9, 1e-3, 0.7, 0.7, 2.0]
    whole = pair.propagate_stiff(*start, 0.0, 2.0, 1e-11, times=times)
    assert (
        np.max(
            np.abs(
                np.append(whole.q_at[1], whole.v_at[1]) - np.array(RIGID["reference"]["0.001"], dtype=float)
            )
        )
        < 1e-11
    )
    assert np.array_equal(whole.q_at[2], whole.q_at[3]) and np.max(np.abs(whole.q_at[4] - whole.q)) < 1e-14
    alone = pair.propagate_stiff(*start, 0.0, 0.7, 1e-11)
    assert np.max(np.abs(whole.q_at[2] - alone.q)) < 1e-11
    some = pair.propagate_stiff(*start, 0.0, 2.0, 1e-11, max_steps=100)
    assert some.outcome == "step budget" and some.steps + some.refused == 100 and some.t < 2.0
    rest = pair.propagate_stiff(some.q, some.v, some.t, 2.0, 1e-11, lost=some.lost, memory=some.memory)
    assert np.array_equal(rest.q, whole.q) and np.array_equal(rest.v, whole.v)
    assert some.steps + rest.steps == whole.steps


@pytest.mark.parametrize(("name", "t_end"), [("rigid_joint", 0.02), ("free_pair", 2.0), ("free_pair", -2.0), ("spatial_stiff", 0.05), ("single_precision", 0.5)])
def test_the_ends_of_its_own_steps_are_those_of_one_call_each(name: str, t_end: float) -> None:
    chain, tol = system(name), 1e-6
    q, v = spatial_start(2, 2) if not chain.is_planar else (np.full(chain.nq, 0.7), np.full(chain.nv, 0.1))
    given = {"p": {"mass": np.ones(2)}} if name == "spatial_stiff" else {}
    found = chain.propagate_stiff(q, v, 0.0, t_end, tol, own=True, **given)
    t, more, ends, refused = 0.0, {}, [], 0
    while t != found.t:
        step = chain.propagate_stiff(q, v, t, t_end, tol, max_steps=1, **given, **more)
        more, refused = {"lost": step.lost, "memory": step.memory}, refused + step.refused
        if step.steps:
            t, q, v = step.t, step.q, step.v
            ends.append((t, *q, *v))
    assert found.outcome == "done" and found.refused == refused and found.steps == len(ends) > 10
    assert np.array_equal(np.column_stack([found.t_at, found.q_at, found.v_at]), np.array(ends))


def test_the_budget_of_own_steps_counts_those_that_were_refused() -> None:
    chain = system("rigid_joint")
    whole = chain.propagate_stiff([1.0, 0.5], [0.0, 0.0], 0.0, 1.0, 1e-6, own=True)
    assert whole.refused > 0
    for most in (1, 5, whole.tried - 1):
        part = chain.propagate_stiff([1.0, 0.5], [0.0, 0.0], 0.0, 1.0, 1e-6, own=True, max_steps=most)
        assert part.outcome == "step budget" and part.tried == most and np.array_equal(part.t_at, whole.t_at[: part.steps])
    with pytest.raises(ArrayError, match="own, which asks for the ends"):
        chain.propagate_stiff([1.0, 0.5], [0.0, 0.0], 0.0, 1.0, 1e-6, own=True, times=[0.5])


def test_there_and_back() -> None:
    """An undamped motion, forwards and backwards."""
    pair = system("free_pair")
    there = pair.propagate_stiff([0.5, 0.2], [0.0, 0.0], 0.0, 2.0, 1e-13)
    back = pair.propagate_stiff(there.q, there.v, 2.0, 0.0, 1e-13)
    assert back.outcome == "done" and back.t == 0.0
    assert np.max(np.abs(back.q - [0.5, 0.2])) < 1e-12 and np.max(np.abs(back.v)) < 1e-12


def test_links_keep_their_length_over_many_steps() -> None:
    q, v = spatial_start(2, 0)
    found = system("spatial_free").propagate_stiff(q, v, 0.0, 20.0, 1e-11)
    assert found.steps > 5_000
    assert np.max(np.abs(np.linalg.norm(found.q.reshape(-1, 3), axis=1) - 1)) < 2e-15
    assert np.max(np.abs(np.sum((found.q * found.v).reshape(-1, 3), axis=1))) < 1e-14


def test_rest_and_blow_up() -> None:
    still = system("overdamped").propagate_stiff([0.0, 0.0], [0.0, 0.0], 0.0, 10.0, 1e-12)
    assert still.outcome == "done" and not np.any(still.q)
    # Dampers read backwards drive: 1e6 e-folds a second leave the numbers soon.
    back = system("overdamped").propagate_stiff([0.1, 0.1], [0.0, 0.0], 0.0, -1.0, 1e-6, max_steps=100_000)
    assert back.outcome in ("not finite", "step budget") and abs(back.t) < 1e-2


def test_bad_input() -> None:
    flow = system("rigid_joint").propagate_stiff
    state = ([1.0, 0.0], [0.0, 0.0])
    with pytest.raises(ToleranceError, match="must be positive and finite"):
        flow(*state, 0.0, 1.0, 0.0)
    with pytest.raises(ArrayError, match=r"must have shape \(2,\)"):
        flow([1.0], [0.0, 0.0], 0.0, 1.0, 1e-6)
    with pytest.raises(ArrayError, match="is not finite"):
        flow([math.nan, 0.0], [0.0, 0.0], 0.0, 1.0, 1e-6)
    with pytest.raises(ArrayError, match="in the order of travel"):
        flow(*state, 0.0, 1.0, 1e-6, times=[0.5, 0.2])
    assert flow(*state, 0.0, 0.1, 1e-30).tol == 2.0**-46


@pytest.mark.parametrize(
    ("kind", "real"),
    [
        (scene(2, "planar", "cart", "mid", "damped", actuated="all"), "float"),
        (scene(2, "planar", "fixed", "runtime"), "double"),
        (scene(2, "spatial", "cart", "runtime_tip", "sprung"), "double"),
        (scene(1, "spatial", "fixed", "mid"), "float"),
    ],
    ids=["planar damped", "planar runtime", "spatial sprung", "one spatial link"],
)
def test_it_compiles_without_a_warning(kind: Scene, real: str, tmp_path: Path) -> None:
    for want in (("propagate_stiff",), ("forward_dynamics", "step_rosenbrock", "propagate_stiff")):
        compiled(
            write_c(replace(kind, name="strict_c", want=want, real=real), tmp_path), *STRICT, "-Wfloat-equal"
        )
