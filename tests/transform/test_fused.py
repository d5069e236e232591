"""Neighbouring loops in one: the same results bit by bit, and two loops where a turn needs another one's results."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from phichain.ir.builder import Builder
from phichain.ir.evaluate import evaluate
from phichain.ir.nodes import For, Program, SinCos
from phichain.lowering.lower import lower_function
from phichain.mechanics import derive
from phichain.scene import Scene
from phichain.transform.fused import with_fused_loops
from phichain.transform.unread import without_unread_cells

X = np.array([0.3, -1.2, 0.7, 2.5])


def pair(second: str, between: str = "", step: int = 1) -> Program:
    """A loop that writes `kept`, something between, and a loop that reads it."""
    builder = Builder("pair", "Pair.")
    x, out, more = builder.input("x", (4,)), builder.output("out", (4,)), builder.output("more", (4,))
    kept = builder.array("kept", 6)
    kept[4], kept[5] = builder.lift(7), builder.lift(9)
    with builder.loop("k", 0, 4) as loop:
        total = loop.carry("total", builder.lift(0))
        kept[loop.index] = builder.let("square", x[loop.index] * x[loop.index])
        loop.follow(total, total + x[loop.index])
    if between == "sines":
        sine, _ = builder.sincos(x, 4)
    if between == "writes":
        kept[2] = builder.lift(5)
    start, stop = (0, 4) if step == 1 else (3, -1)
    with builder.loop("k", start, stop, step) as loop:
        k = loop.index
        value = total * x[k] if second == "total" else kept[{"same": k, "next": k + 1, "first": 0}[second]]
        out[k] = value + 1
        more[k] = sine[k] * kept[k] if between == "sines" else value * 2
    return builder.finish()


def loops(program: Program) -> int:
    return sum(isinstance(statement, For) for statement in program.body)


def same(before: Program, after: Program) -> bool:
    first, second = (evaluate(program, {"x": X}) for program in (before, after))
    return all(np.array_equal(first[name], second[name]) for name in first)


@pytest.mark.parametrize(
    ("program", "count"),
    [
        (pair("same"), 1), (pair("same", "sines"), 1), (pair("next"), 2), (pair("first"), 2), (pair("total"), 2),
        (pair("same", "writes"), 2), (pair("same", step=-1), 2),
    ],
)  # fmt: skip
def test_loops_become_one_where_turns_need_no_others(program: Program, count: int) -> None:
    after = with_fused_loops(program)
    assert same(program, after) and loops(after) == count


def test_what_a_turn_hands_on_has_no_cell() -> None:
    after = without_unread_cells(with_fused_loops(pair("same")))
    assert same(pair("same"), after) and not after.work


def test_what_is_written_over_is_read_anew() -> None:
    builder = Builder("over", "Over.")
    x, out, kept = builder.input("x", (4,)), builder.output("out", (4,)), builder.array("kept", 4)
    with builder.loop("k", 0, 4) as loop:
        kept[loop.index] = builder.let("twice", x[loop.index] * 2)
        with builder.loop("j", 0, 4) as inner:
            kept[inner.index] = x[inner.index] * 3
        out[loop.index] = kept[loop.index] + 1
    program = builder.finish()
    assert same(program, with_fused_loops(program))


def test_what_a_loop_within_writes_over_it_reads_anew() -> None:
    builder = Builder("within", "Within.")
    x, out, kept = builder.input("x", (4,)), builder.output("out", (4,)), builder.array("kept", 4)
    with builder.loop("k", 0, 4) as loop:
        kept[loop.index] = builder.let("twice", x[loop.index] * 2)
        with builder.loop("j", 0, 4) as inner:
            kept[loop.index] = kept[loop.index] + x[inner.index]
        out[loop.index] = kept[loop.index] + 1
    program = builder.finish()
    assert same(program, with_fused_loops(program))


def test_a_loop_goes_behind_sines_that_the_next_one_reads() -> None:
    body = with_fused_loops(pair("same", "sines")).body
    places = [type(statement) for statement in body]
    assert places.index(SinCos) < places.index(For)


def test_jacobians_on_targets_have_fewer_loops_and_the_same_bits() -> None:
    scene = Scene("chain", 5, mass=(0.3, 0.2, 0.1, 0.5, 0.2), length=0.2, com=0.1, actuated="all", real="float", trig="bundled", want=("dynamics_and_jacobian",))
    apart, fused = (lower_function(derive(replace(scene, code=code)), "dynamics_and_jacobian", "loops") for code in ("auto", "loops"))
    assert loops(fused) == 6
    given = {array.name: np.random.default_rng(3).uniform(-2.0, 2.0, array.shape) for array in apart.inputs}
    expected, found = evaluate(apart, given), evaluate(fused, given)
    assert all(np.allclose(found[name], expected[name], rtol=0, atol=1e-10 * np.max(np.abs(expected[name]))) for name in expected)
    assert fused == with_fused_loops(fused)
