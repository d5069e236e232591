"""Loops of one turn or none, and arrays of one cell, are gone; the function is the same to the last bit."""

from __future__ import annotations

import numpy as np
import pytest

from phichain.ir.builder import Builder
from phichain.ir.evaluate import evaluate
from phichain.ir.nodes import For, Program, walk
from phichain.ir.short_loops import without_short_loops
from phichain.lowering.lower import lower_function
from phichain.mechanics import derive
from phichain.scene import Scene


def sweep(count: int) -> Program:
    """Running sums of sines, with what a writer may leave: a loop that depends on another's index, a cell of one."""
    builder = Builder("sweep", "Sums.")
    x = builder.input("x", (count,))
    y = builder.output("y", (count,))
    sine, _ = builder.sincos(x, count)
    last = builder.array("last", 1)
    with builder.loop("i", 0, count) as outer:
        total = outer.carry("total", 1)
        here = builder.let("here", total + sine[outer.index])
        with builder.loop("j", 0, outer.index) as inner:
            part = inner.carry("part", 0)
            inner.follow(part, part + x[inner.index])
        y[outer.index] = here * part + here
        outer.follow(total, here)
    last[0] = total
    with builder.loop("k", 0, 1) as once:
        y[once.index] = last[once.index] + x[once.index]
    return builder.finish()


def short(program: Program) -> list[For]:
    loops = [statement for statement in walk(program.body) if isinstance(statement, For)]
    return [loop for loop in loops if not (loop.stop - loop.start).terms and abs((loop.stop - loop.start).offset) < 2]


@pytest.mark.parametrize("count", [1, 2, 5])
def test_the_values_are_those_of_the_loops(count: int) -> None:
    program = sweep(count)
    made = without_short_loops(program)
    assert short(program) and not short(made)
    assert not [array for array in made.work if array.size == 1]
    x = np.random.default_rng(count).uniform(-3, 3, count)
    assert np.array_equal(evaluate(made, {"x": x})["y"], evaluate(program, {"x": x})["y"])
    assert made.is_straight_line == (count == 1)


def test_what_has_no_short_loop_is_left_as_it_is() -> None:
    program = lower_function(derive(Scene("six", 6, mass=1.0, length=1.0, com=0.5)), "forward_dynamics", "loops")
    assert without_short_loops(program) is program


@pytest.mark.parametrize("links", [1, 2, 3, 4])
@pytest.mark.parametrize("name", ["forward_dynamics", "state_jacobian", "inverse_dynamics", "linearization"])
def test_no_emitted_program_has_one(name: str, links: int) -> None:
    for com, trig in ((None, None), (0.4, None), (0.4, "bundled")):
        scene = Scene("few", links, base="cart", mass=1.0, length=1.0, com=com, cart_mass=2.0, damping=0.1, trig=trig)
        program = lower_function(derive(scene), name, "loops")
        assert not short(program)
        assert not [array.name for array in program.work if array.size == 1]
