"""Loops on a target: the shortest text, the same accelerations and derivatives as the straight-line code of hosts."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from phichain.ir.evaluate import evaluate
from phichain.ir.nodes import For, walk
from phichain.ir.passes import total_operations
from phichain.lowering.lower import lower_function
from phichain.lowering.planar.by_columns.sweeps import serves
from phichain.mechanics import derive
from phichain.scene import Scene

CHAINS = {
    "one link": Scene("one", 1, mass=0.3, length=0.5, com=0.2, trig="bundled"),
    "unlike": Scene("unlike", 3, mass=(0.7, 1.9, 0.4), length=(0.5, 1.3, 0.8), com=(0.2, 0.9, 0.4), actuated="all", trig="bundled"),
    "four": Scene("four", 4, mass=(0.7, 1.9, 0.4, 1.2), length=(0.5, 1.3, 0.8, 0.3), com=(0.2, 0.9, 0.4, 0.1), actuated="all", trig="bundled"),
    "free": Scene("free_chain", 4, mass=0.2, length=(0.5, 1.3, 0.8, 0.3), com=0.1, gravity=3.7, trig="libm"),
    "both ends": Scene("six", 6, mass=0.2, length=0.3, com=0.1, actuated="all", damping=0.01, trig="libm"),
    "cart": Scene("cart", 4, base="cart", mass=0.2, length=0.3, com=0.1, cart_mass=0.5, cart_damping=0.2, trig="bundled"),
    "rods": Scene("rods", 4, mass=0.2, length=0.3, com=0.15, inertia=0.0015, stiffness=0.3, trig="bundled"),
    "adjacent": Scene("adjacent", 4, mass=0.2, length=0.3, com=0.1, angles="adjacent", actuated="all", trig="bundled"),
}


@pytest.mark.long
@pytest.mark.parametrize("kind", CHAINS)
@pytest.mark.parametrize("name", ["forward_dynamics", "dynamics_and_jacobian"])
def test_loops_on_targets_agree_with_straight_line_code_of_hosts(kind: str, name: str) -> None:
    scene = CHAINS[kind]
    short = lower_function(derive(scene), name, "loops")
    flat = lower_function(derive(replace(scene, trig=None)), name, "unrolled")
    source = np.random.default_rng(scene.links)
    given = {array.name: source.uniform(-2.0, 2.0, array.shape) for array in short.inputs}
    found, expected = evaluate(short, given), evaluate(flat, given)
    for result, values in expected.items():
        scale = max(1.0, float(np.max(np.abs(values))))
        assert np.max(np.abs(np.asarray(found[result]) - values)) < 1e-11 * scale, result


@pytest.mark.parametrize("kind", [*CHAINS, "two"])
def test_straight_line_code_on_targets_agrees_with_that_of_hosts(kind: str) -> None:
    """Both ends written out on a wall, and every operation where it is needed."""
    scene = CHAINS.get(kind) or replace(CHAINS["unlike"], links=2, mass=(0.7, 1.9), length=(0.5, 1.3), com=(0.2, 0.9))
    short, flat = (lower_function(derive(one), "forward_dynamics", "unrolled") for one in (scene, replace(scene, trig=None)))
    source = np.random.default_rng(scene.links)
    given = {array.name: source.uniform(-2.0, 2.0, array.shape) for array in short.inputs}
    found, expected = (np.asarray(evaluate(program, given)["a"]) for program in (short, flat))
    assert np.max(np.abs(found - expected)) < 1e-12 * max(1.0, float(np.max(np.abs(expected))))


@pytest.mark.parametrize(("links", "saved"), [(1, 0), (2, 4), (3, 4), (4, 5)])
def test_both_ends_written_out_take_fewer_operations(links: int, saved: int) -> None:
    """Than the sweep of hosts, of which links like one another leave no factors."""
    chain = Scene("alike", links, mass=0.25, length=0.25, com=0.125, actuated="all", trig="bundled")
    short, host = (total_operations(lower_function(derive(scene), "forward_dynamics", "unrolled")) for scene in (chain, replace(chain, trig=None)))
    assert host - short >= saved


def test_the_sweep_inwards_is_one_loop() -> None:
    """Where text is dear nothing of it stands outside, and one end serves; hosts peel the tip and go from both."""
    chain = replace(CHAINS["both ends"], damping=None)
    short, host = (lower_function(derive(scene), "forward_dynamics", "loops") for scene in (chain, replace(chain, trig=None)))
    divisions = [sum(getattr(statement, "kind", "") == "div" for statement in walk(program.body)) for program in (short, host)]
    assert divisions[0] == 1 < divisions[1]
    assert sum(isinstance(statement, For) for statement in short.body) < sum(1 for _ in walk(host.body))
    assert len(list(walk(short.body))) < 0.6 * len(list(walk(host.body)))


@pytest.mark.parametrize(
    ("more", "is_taken"),
    [
        ({}, True), ({"links": 3}, True), ({"actuated": "none"}, True), ({"length": "runtime"}, True), ({"mass": (9.0, 1.0, 1.0, 3.0)}, True),
        ({"links": 5}, False), ({"links": 2}, False), ({"mass": (1.0, 1.0, 1.0, 3.1)}, False), ({"mass": "runtime"}, False),
        ({"trig": None}, False), ({"code": "auto"}, False), ({"com": None}, False), ({"inertia": 0.01}, False), ({"stiffness": 0.3}, False),
        ({"damping": 0.3}, False), ({"angles": "absolute"}, False), ({"base": "cart", "cart_mass": 1.0}, False), ({"actuated": [1, 2]}, False),
    ],
    ids=str,
)  # fmt: skip
def test_columns_go_one_by_one_where_that_is_shorter_and_loses_no_digits(more: dict[str, Any], is_taken: bool) -> None:
    given = {"links": 4, "mass": 0.2, "length": 0.3, "com": 0.1, "actuated": "all", "trig": "bundled", "code": "loops", **more}
    assert serves(Scene("chain", **given)) is is_taken


def test_columns_one_by_one_are_less_than_two_thirds_of_the_statements() -> None:
    four, five = (
        lower_function(
            derive(Scene("chain", links, mass=0.2, length=0.3, com=0.1, actuated="all", trig="bundled", code="loops")), "dynamics_and_jacobian", "loops"
        )
        for links in (4, 5)
    )
    assert len(list(walk(four.body))) < 2 / 3 * len(list(walk(five.body)))


def test_columns_follow_the_accelerations_link_by_link() -> None:
    """Three loops for the columns of each link within that of the accelerations, and what disturbs links kept for one of them."""
    chain = Scene("chain", 4, mass=0.2, length=0.3, com=0.1, actuated="all", trig="bundled", code="loops")
    program = lower_function(derive(chain), "dynamics_and_jacobian", "loops")
    assert sum(isinstance(statement, For) for statement in program.body) == 4
    assert {array.name: array.size for array in program.work}["cause"] == 13
    assert not any("minor" in getattr(statement, "result", "") for statement in walk(program.body))
