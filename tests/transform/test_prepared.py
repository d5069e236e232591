"""What runtime parameters alone determine stands apart: the two parts together are the function, to the last bit."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from phichain.ir import count_operations, evaluate, total_operations
from phichain.ir.inline import inline
from phichain.ir.nodes import Op, Program
from phichain.ir.varying import varying
from phichain.lowering import lower_function
from phichain.mechanics import derive
from phichain.scene import Scene
from phichain.transform.prepared import PREPARED, prepared

KINDS: dict[str, dict[str, Any]] = {
    "tips": {"mass": "runtime", "length": "runtime"},
    "half way, all runtime": {"mass": "runtime", "length": "runtime", "com": "runtime", "gravity": "runtime"},
    "cart, torques, dampers": {
        "mass": "runtime", "length": 0.4, "com": 0.2, "base": "cart", "cart_mass": "runtime", "damping": 0.1,
        "actuated": "all", "angles": "absolute",
    },
    "space": {"space": "spatial", "mass": "runtime", "length": "runtime", "base": "cart", "cart_mass": 1.0},
}  # fmt: skip


def function(kind: str, code: str, links: int = 8) -> Program:
    numbers = {"mass": 1.0, "length": 1.0} | KINDS[kind]
    return inline(lower_function(derive(Scene("a", links, **numbers)), "forward_dynamics", code))


@pytest.mark.parametrize("code", ["loops", "unrolled"])
@pytest.mark.parametrize("kind", KINDS)
def test_the_two_parts_are_the_function_to_the_last_bit(kind: str, code: str) -> None:
    program, rng = function(kind, code), np.random.default_rng(1)
    given = {array.name: rng.uniform(0.5, 1.5, array.shape or None) for array in (*program.params, *program.inputs)}
    split = prepared(program)
    assert split is not None and not split.first.inputs
    first = evaluate(split.first, {array.name: given[array.name] for array in split.first.params})[PREPARED]
    assert len(first) == split.size
    rest = evaluate(split.rest, {**given, PREPARED: first})["a"]
    assert rest.tolist() == evaluate(program, given)["a"].tolist()


@pytest.mark.parametrize("kind", KINDS)
def test_the_rest_computes_nothing_of_parameters_alone(kind: str) -> None:
    """Straight-line code, so that every operation stands by itself; no operation is done twice."""
    program = function(kind, "unrolled")
    split = prepared(program)
    assert split is not None
    moves = varying(split.rest, {array.name for array in split.rest.inputs if array.name != PREPARED})
    assert count_operations(split.rest) == count_operations_of(split.rest, moves)
    assert total_operations(split.first) + total_operations(split.rest) == total_operations(program)


def count_operations_of(program: Program, moves: frozenset[str]) -> Any:
    """Those whose result is among these."""
    kept = tuple(s for s in program.body if not isinstance(s, Op) or s.result in moves)
    return count_operations(replace(program, body=kept))


def test_parameters_are_divided_by_three_times_a_link() -> None:
    """1/m, 1/l and 1/r: what a link in its own units asks of parameters is made of these by multiplications."""
    split = prepared(function("half way, all runtime", "unrolled"))
    assert split is not None
    assert count_operations(split.first)["div"] <= 3 * 8
    assert count_operations(split.rest)["div"] <= 8 + 3


def test_a_function_without_parameters_is_not_split() -> None:
    scene = Scene("a", 6, mass=1.0, length=1.0, com=0.5)
    assert prepared(lower_function(derive(scene), "forward_dynamics", "loops")) is None
