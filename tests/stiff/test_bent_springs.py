"""Stiff springs in space: bends keep the digits that unit vectors do not hold, so that steps follow the motion and not rounding."""

from __future__ import annotations

from functools import cache
from importlib import import_module
from typing import Any

import numpy as np
import pytest

from phichain.errors import ProofError
from phichain.ir.evaluate import evaluate
from phichain.lowering.lower import lower_function
from phichain.mechanics import derive
from phichain.pipeline import build
from phichain.proof import prove
from phichain.scene import Scene
from phichain.system import System
from tests.lowering.chains import scene
from tests.proof.mutations import mutants
from tests.stiff.systems import spatial_start

SLANT = np.array([0.6, 0.8])


@cache
def bent(space: str, stiffness: float, damping: float, **more: Any) -> System:
    """Links of 1 kg and 1 m whose second joint is stiff."""
    joints = {"stiffness": [0.0, stiffness], "damping": [0.0, damping]}
    return build(Scene(f"bent_{space}", 2, space=space, mass=1.0, length=1.0, want=("propagate", "propagate_stiff"), **joints, **more))


def in_a_vertical_plane(angles: np.ndarray, rates: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Unit vectors and angular velocities of links at angles from below in one vertical plane."""
    q = np.column_stack([np.outer(np.sin(angles), SLANT), np.cos(angles)])
    return q.ravel(), np.outer(rates, [-SLANT[1], SLANT[0], 0.0]).ravel()


@pytest.mark.long
@pytest.mark.parametrize(("stiffness", "damping"), [(1e6, 1e3), (1e9, 3e4), (1e9, 3e6)])
def test_in_a_vertical_plane_they_take_the_steps_that_planar_ones_take(stiffness: float, damping: float) -> None:
    """From rounded vectors the second takes 1000 times as many: the torque of what rounding takes, 1e-16 k, jumps from step to step."""
    angles = np.array([0.3, 0.3 + 1e-6])
    flat = bent("planar", stiffness, damping).propagate_stiff([0.3, 1e-6], [0.0, 0.0], 0.0, 0.2, 1e-12)
    found = bent("spatial", stiffness, damping).propagate_stiff(*in_a_vertical_plane(angles, np.zeros(2)), 0.0, 0.2, 1e-12, max_steps=2000)
    q, v = in_a_vertical_plane(np.cumsum(flat.q), np.cumsum(flat.v))
    assert flat.outcome == found.outcome == "done" and found.steps < flat.steps
    assert np.max(np.abs(found.q - q)) < 5e-13 and np.max(np.abs(found.v - v)) < 5e-12


@pytest.mark.long
def test_a_joint_of_1e13_newton_metres_arrives() -> None:
    """From rounded vectors its steps are shorter than a nanosecond. Solves are known to 1e-13 of the rates."""
    flat = bent("planar", 1e13, 3e6).propagate_stiff([0.3, 0.0], [0.0, 0.0], 0.0, 0.2, 1e-12)
    start = in_a_vertical_plane(np.array([0.3, 0.3]), np.zeros(2))
    found = bent("spatial", 1e13, 3e6).propagate_stiff(*start, 0.0, 0.2, 1e-12, max_steps=10_000)
    assert found.outcome == "done"
    assert np.max(np.abs(found.q - in_a_vertical_plane(np.cumsum(flat.q), np.cumsum(flat.v))[0])) < 5e-12


@pytest.mark.long
@pytest.mark.parametrize(
    "more",
    [
        {"com": 0.4},
        {"base": "cart", "cart_mass": 0.3, "mass": "runtime"},
        {"inertia": [0.1, 0.02], "com": [0.5, 0.3]},
        {"inertia": [0.1, 0.02], "com": [0.0, 0.0]},
    ],
    ids=["inner masses", "runtime masses on a cart", "inertia", "at their centres"],
)  # fmt: skip
def test_every_form_of_the_dynamics_goes_where_the_taylor_flow_goes(more: dict[str, Any]) -> None:
    table = {"space": "spatial", "links": 2, "mass": [2.0, 0.01], "length": [0.5, 1.5], "stiffness": [0.0, 1e5], "damping": [0.01, 20.0], **more}
    chain = build(Scene("bent_forms", want=("propagate", "propagate_stiff"), **table))
    q, v = spatial_start(2, 2 if "base" in more else 0)
    given = {"p": {"mass": [2.0, 0.01]}} if "mass" in more else {}
    given |= {"u": [0.2, -0.1]} if "base" in more else {}
    near = chain.propagate(q, v, 0.0, 0.05, 1e-16, max_steps=200_000, **given)
    found = chain.propagate_stiff(q, v, 0.0, 0.05, 1e-10, max_steps=200_000, **given)
    assert near.outcome == found.outcome == "done"
    assert np.max(np.abs(found.q - near.q)) < 1e-9 and np.max(np.abs(found.v - near.v)) < 1e-9 * np.max(np.abs(near.v)) + 1e-8


@pytest.mark.parametrize("kind", ["tip", "mid"])
def test_without_lost_digits_a_step_is_the_plain_one(kind: str) -> None:
    chain = scene(3, "spatial", "cart", kind, "sprung")
    model, rng = derive(chain), np.random.default_rng(8)
    q, v = spatial_start(3, 2)
    given = {"h": [1e-3], "q": list(q), "v": list(v), "u": list(rng.normal(size=chain.nu))}
    plain = evaluate(lower_function(model, "rosenbrock_increment"), given)
    ours = evaluate(lower_function(model, "bent_increment"), given | {"lost": [0.0] * chain.nq})
    for name, value in plain.items():
        assert np.allclose(ours[name], value, rtol=1e-11, atol=1e-15)


def test_what_the_flow_leans_on_is_proven(monkeypatch: pytest.MonkeyPatch) -> None:
    model = derive(Scene("bent_proof", 2, space="spatial", mass=[1.3, 0.4], length=[0.7, 0.9], stiffness=[2.0, 0.5], want=("propagate_stiff",)))
    prove(model)
    court, refused = import_module("phichain.proof.prove"), 0
    for mutant in mutants(lower_function(model, "bent_dynamics", "loops"), 2):
        def changed(of: Any, name: str, code: Any = "auto", program: Any = mutant.program) -> Any:
            return program if name == "bent_dynamics" else lower_function(of, name, code)

        monkeypatch.setattr(court, "lower_function", changed)
        try:
            prove(model)
        except ProofError as fault:
            refused += fault.function == "bent_dynamics"
    assert refused >= 15


def test_a_run_in_pieces_is_the_run() -> None:
    chain = bent("spatial", 1e9, 3e4)
    start = in_a_vertical_plane(np.array([0.3, 0.3 + 1e-6]), np.array([0.1, 0.2]))
    whole = chain.propagate_stiff(*start, 0.0, 0.2, 1e-11)
    some = chain.propagate_stiff(*start, 0.0, 0.2, 1e-11, max_steps=40)
    rest = chain.propagate_stiff(some.q, some.v, some.t, 0.2, 1e-11, lost=some.lost, memory=some.memory)
    assert some.outcome == "step budget" and some.steps + rest.steps == whole.steps
    assert np.array_equal(whole.q, rest.q) and np.array_equal(whole.v, rest.v)
