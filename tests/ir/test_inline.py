"""Calls replaced by what they call."""

from __future__ import annotations

import numpy as np
import pytest

from phichain.ir.builder import Builder
from phichain.ir.evaluate import evaluate
from phichain.ir.inline import inline
from phichain.ir.nodes import Call, For, Program, walk
from phichain.lowering.lower import lower_function
from phichain.mechanics import derive
from phichain.scene import Scene
from tests.emit.casadi_scenes import SCENES, random_arguments, relative_error


def _weighted() -> Program:
    """out_i = w_i x_i + sum of x, with a table, a work array and a carried sum."""
    b = Builder("weighted", "")
    x, out = b.input("x", (3,)), b.output("out", (3,))
    weights = b.table("weights", 3, lambda k: b.lift(2) if k == 0 else b.lift(5))
    squares = b.array("squares", 3)
    with b.loop("k", 0, 3) as loop:
        total = loop.carry("total", 0)
        squares[loop.index] = x[loop.index] * x[loop.index]
        loop.follow(total, total + x[loop.index])
    with b.loop("k", 0, 3) as loop:
        out[loop.index] = weights[loop.index] * squares[loop.index] + total
    return b.finish()


def _twice() -> Program:
    """The callee applied twice, beside names of its own that the callee uses too."""
    b = Builder("twice", "")
    x, out = b.input("x", (3,)), b.output("out", (3,))
    squares, total = b.array("squares", 1), b.let("total", x[0] - x[1])
    squares[0] = total * total
    (once,) = b.call(_weighted(), [x], {"once": 3})
    (again,) = b.call(_weighted(), [once], {"again": 3})
    with b.loop("k", 0, 3) as loop:
        out[loop.index] = again[loop.index] + squares[0] * total
    return b.finish()


def test_an_inlined_program_computes_the_same() -> None:
    program, x = _twice(), np.array([0.5, -1.25, 3.0])
    inlined = inline(program)
    assert not inlined.callees and not any(isinstance(s, Call) for s in walk(inlined.body))
    assert np.array_equal(evaluate(inlined, {"x": x})["out"], evaluate(program, {"x": x})["out"])


def test_every_name_is_defined_once() -> None:
    inlined = inline(_twice())
    carried = [carry.name for s in walk(inlined.body) if isinstance(s, For) for carry in s.carries]
    arrays = [array.name for array in (*inlined.inputs, *inlined.outputs, *inlined.work)]
    defined = [s.result for s in walk(inlined.body) if hasattr(s, "result")]
    names = [*arrays, *inlined.tables, *carried, *defined]
    assert len(names) == len(set(names))


def test_a_program_without_calls_stays_itself() -> None:
    program = _weighted()
    assert inline(program) is program


@pytest.mark.parametrize("scene", SCENES[::3], ids=lambda scene: scene.name)
def test_steps_of_real_scenes(scene: Scene) -> None:
    program = lower_function(derive(scene), "step", "loops")
    assert program.callees
    arguments = random_arguments(program, np.random.default_rng(1), scene.space)
    expected = evaluate(program, arguments)
    for name, value in evaluate(inline(program), arguments).items():
        assert relative_error(value, expected[name]) == 0
