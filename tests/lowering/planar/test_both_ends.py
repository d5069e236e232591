"""Planar masses before the ends, eliminated from both ends: half the dependency depth, and no digit less than from the tip."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from phichain.ir import evaluate, total_operations
from phichain.ir.builder import Builder
from phichain.ir.interpret import Algebra, run
from phichain.ir.nodes import Program
from phichain.lowering import lower_function
from phichain.lowering.chain.parameters import Parameters
from phichain.lowering.dynamics import OF_MANY
from phichain.lowering.planar import articulated
from phichain.lowering.planar.both_ends.base_side import suits
from phichain.lowering.planar.joints import planar_state
from phichain.mechanics import derive
from phichain.reference import reference
from phichain.scene import Scene
from tests.reference_cases import relative_error

#: What an operation waits for, in units of one addition; a multiplication feeds an addition at no cost of its own.
LATENCY = {"div": 4, "sin": 10, "cos": 10, "neg": 0}


def chain(links: int, **more: Any) -> Scene:
    """Masses half way, in numbers without a pattern."""
    rng = np.random.default_rng(links)
    mass, length = np.exp(rng.uniform(-1.5, 1.5, links)).round(3), rng.uniform(0.3, 1.4, links).round(3)
    keys = {"mass": mass.tolist(), "length": length.tolist(), "com": (length / 2).tolist()}
    return Scene("a", links, **(keys | more))


def from_tip(scene: Scene) -> Program:
    """The accelerations by the sweep from the tip alone."""
    builder = Builder("forward_dynamics", "")
    parameters = Parameters(builder, derive(scene))
    q, v = builder.input("q", (scene.nq,)), builder.input("v", (scene.nv,))
    u = builder.input("u", (scene.nu,)) if scene.nu else None
    a = builder.output("a", (scene.nv,))
    articulated.accelerations(builder, scene, parameters, planar_state(builder, scene, q, v), u, a)
    return builder.finish()


def depth(program: Program) -> int:
    """Longest chain of operations of which each waits for the one before."""

    def later(kind: str, args: Any, label: str) -> int:
        return max(args) + LATENCY.get(kind, 1)

    zeros = {array.name: [0] * array.size for array in (*program.params, *program.inputs)}
    return max(run(program, Algebra(lambda value: 0, later), zeros)["a"])


def forward(scene: Scene, code: str = "loops") -> Program:
    return lower_function(derive(scene), "forward_dynamics", code)


KINDS: dict[str, dict[str, Any]] = {
    "plain": {},
    "torques": {"actuated": "all"},
    "cart": {"base": "cart", "cart_mass": 1.5},
    "cart, torques, springs, dampers": {
        "base": "cart", "cart_mass": 1.5, "actuated": "all", "stiffness": 2.0, "damping": 0.1, "angles": "absolute",
    },
    "adjacent, some torques": {"angles": "adjacent", "actuated": "all", "damping": 0.1},
    "runtime masses": {"mass": "runtime", "actuated": "all"},
    "all runtime": {"mass": "runtime", "length": "runtime", "com": "runtime", "gravity": "runtime"},
    "float": {"real": "float", "base": "cart", "cart_mass": 1.5},
}  # fmt: skip


@pytest.mark.parametrize("kind", KINDS)
def test_the_dependency_depth_is_under_two_thirds(kind: str) -> None:
    """At no more than a fourth more operations, those on runtime parameters alone included; long chains alone do them in lanes, too."""
    scene = chain(32, **KINDS[kind])
    assert suits(scene)
    found, before = lower_function(derive(scene), OF_MANY, "loops"), from_tip(scene)
    assert depth(found) < 0.66 * depth(before)
    assert total_operations(found) < 1.25 * total_operations(before)


@pytest.mark.parametrize("links", [2, 4])
def test_short_chains_stay_with_the_sweep_from_the_tip(links: int) -> None:
    assert not suits(chain(links))


def test_tables_of_runtime_parameters_pay_on_longer_chains() -> None:
    """On a host they take less than a chain that waits half as long saves; where memory is dear they have to be stored."""
    assert [suits(chain(links, mass="runtime")) for links in (5, 6)] == [False, True]
    assert [suits(chain(links, mass="runtime", trig="bundled")) for links in (11, 12)] == [False, True]


def test_couples_on_links_of_unlike_leverage_stay_with_the_sweep_from_the_tip() -> None:
    com = [0.5, 0.01] * 4
    assert suits(chain(8, length=1.0, com=com))
    assert not suits(chain(8, length=1.0, com=com, actuated="all"))
    assert not suits(chain(8, length="runtime", com=com, damping=0.1))


def state(scene: Scene, rng: np.random.Generator, shape: str) -> dict[str, Any]:
    """A random state; angles of all sizes, or right ones and near them."""
    q = rng.uniform(-np.pi, np.pi, scene.nq)
    if shape == "of all sizes":
        q = rng.choice([-1, 1], scene.nq) * 10 ** rng.uniform(-10, 0.4, scene.nq)
    if shape == "right":
        q = rng.choice([0.0, np.pi / 2, -np.pi / 2, np.pi], scene.nq)
    inputs = {"q": q.tolist(), "v": rng.normal(size=scene.nv).tolist()}
    return inputs | ({"u": rng.normal(size=scene.nu).tolist()} if scene.nu else {})


@pytest.mark.long
@pytest.mark.parametrize("shape", ["any", "of all sizes", "right"])
@pytest.mark.parametrize("links", [5, 6, 9])
@pytest.mark.parametrize(
    "kind", ["plain", "torques", "cart", "cart, torques, springs, dampers", "adjacent, some torques"]
)
def test_masses_over_eight_decades_keep_all_digits(kind: str, links: int, shape: str) -> None:
    """Against 30 digits of the dense equations; large couples on light links between heavy ones are among them."""
    rng = np.random.default_rng(17 * links)
    for _ in range(3):
        scene = chain(
            links, **{**KINDS[kind], "mass": (10 ** rng.uniform(-4, 4, links)).tolist(), "angles": "relative"}
        )
        if scene.has_cart:
            scene = chain(links, **{
                **KINDS[kind], "mass": scene.mass, "angles": "relative", "cart_mass": float(10 ** rng.uniform(-4, 4)),
            })  # fmt: skip
        assert suits(scene)
        inputs = state(scene, rng, shape)
        truth = reference(scene, "forward_dynamics", inputs, digits=40)["a"]
        assert relative_error(evaluate(forward(scene), inputs)["a"].tolist(), truth) < 1e-13


@pytest.mark.parametrize("links", [5, 8])
@pytest.mark.parametrize("place", [1e-8, 1e-3, 1 - 1e-8, 1.0])
def test_masses_anywhere_on_their_links(links: int, place: float) -> None:
    """With torques on links of one leverage, and on masses over eight decades at the ends."""
    rng = np.random.default_rng(links)
    mass = (10 ** rng.uniform(-4, 4, links)).tolist() if place == 1.0 else 0.7
    scene = chain(links, length=1.0, com=place, mass=mass, actuated="all")
    assert suits(scene)
    inputs = state(scene, rng, "any")
    truth = reference(scene, "forward_dynamics", inputs, digits=40)["a"]
    assert relative_error(evaluate(forward(scene), inputs)["a"].tolist(), truth) < 2e-14


@pytest.mark.parametrize("kind", ["plain", "cart, torques, springs, dampers", "runtime masses"])
@pytest.mark.parametrize("links", [5, 6, 7, 8, 12, 13])
def test_both_shapes_of_the_code_and_the_sweep_from_the_tip_agree(kind: str, links: int) -> None:
    scene, rng = chain(links, **KINDS[kind]), np.random.default_rng(links)
    inputs = state(scene, rng, "any") | (
        {"mass": rng.uniform(0.5, 2.0, links).tolist()} if scene.runtime else {}
    )
    expected = evaluate(from_tip(scene), inputs)["a"]
    for code in ("loops", "unrolled"):
        np.testing.assert_allclose(evaluate(forward(scene, code), inputs)["a"], expected, rtol=1e-11)


def test_a_couple_on_a_light_link_between_heavy_ones_is_balanced_without_loss() -> None:
    """Forces of 1e7 in its units cancel there; what counts is the acceleration of its ends."""
    rng = np.random.default_rng(3)
    scene = chain(5, mass=[1e-6, 1e6, 1e6, 1e6, 1e6], base="cart", cart_mass=1e-7, actuated="all")
    for _ in range(5):
        inputs = state(scene, rng, "any")
        truth = reference(scene, "forward_dynamics", inputs, digits=40)["a"]
        assert relative_error(evaluate(forward(scene), inputs)["a"].tolist(), truth) < 1e-13
