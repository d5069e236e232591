"""Products of runtime parameters where they are read: the same numbers, no table of theirs, and all that `prepare` keeps."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from phichain.ir import evaluate, total_operations
from phichain.ir.builder import Builder
from phichain.ir.nodes import For, Program, Store, walk
from phichain.lowering import lower_function
from phichain.lowering.preparation import preparation
from phichain.mechanics import derive
from phichain.scene import Scene
from phichain.transform.in_place import with_products_in_place

FREE: dict[str, Any] = {"mass": "runtime", "length": "runtime", "com": "runtime"}
KINDS: list[dict[str, Any]] = [
    {}, {"actuated": "all"}, {"base": "cart", "cart_mass": "runtime"}, {"damping": "runtime"}, {"inertia": "runtime"},
    {"length": 1.0, "com": 0.5}, {"angles": "absolute"},
]  # fmt: skip


def chain(links: int, **more: Any) -> Scene:
    return Scene("some", links, **(FREE | {"actuated": "cart" if "base" in more else "none", "code": "loops"} | more))


def arguments(scene: Scene) -> dict[str, Any]:
    some = np.random.default_rng(1)
    drawn: dict[str, Any] = {name: some.uniform(0.5, 1.5, () if name == "cart_mass" else scene.links) for name in scene.runtime}
    return drawn | {"q": some.uniform(-3, 3, scene.nq), "v": some.normal(size=scene.nv)} | ({"u": some.normal(size=scene.nu)} if scene.nu else {})


def tables(program: Program) -> set[str]:
    """Arrays that loops over parameters alone write, whole."""
    loops = [s for s in program.body if isinstance(s, For) and not s.carries and isinstance(s.body[-1], Store)]
    return {s.cell.array for loop in loops for s in walk(loop.body) if isinstance(s, Store)}


@pytest.mark.parametrize("more", KINDS, ids=lambda more: "-".join(more) or "plain")
@pytest.mark.parametrize("links", [5, 8, 32, 33])
def test_the_same_accelerations(links: int, more: dict[str, Any]) -> None:
    """To rounding, whether or not a table's cells are all products: the first link has no link before it."""
    scene = chain(links, **more)
    kept = lower_function(derive(scene), "forward_dynamics", "loops", keeps_tables=True)
    placed, given = with_products_in_place(kept), arguments(scene)
    expected = evaluate(kept, given)["a"]
    assert np.max(np.abs(evaluate(placed, given)["a"] - expected)) <= 4e-15 * np.max(np.abs(expected))
    assert tables(placed) < tables(kept)
    assert total_operations(placed) <= total_operations(kept)


def test_what_is_prepared_keeps_its_tables() -> None:
    """And so what is done at every state has the fewest operations."""
    scene = chain(8)
    placed = lower_function(derive(scene), "forward_dynamics")
    assert "minor_lever" not in {array.name for array in placed.work}
    assert preparation(derive(scene)).operations[1] < 0.85 * total_operations(placed)


def _program(first: int) -> Program:
    """out[k] = square[k - first] + square[k - first], a table of p[k]^2; 7 beyond the first cell, which no turn of the loop writes."""
    b = Builder("some", "")
    p, q, out = b.param("p", (4,)), b.input("q", (4,)), b.output("out", (4,))
    square = b.array("square", 4)
    with b.loop("k", 1, 4) as loop:
        square[loop.index] = p[loop.index] * p[loop.index]
    if not first:
        square[0] = b.lift(7)
    with b.loop("k", first, 4) as loop:
        out[loop.index] = q[loop.index] * (square[loop.index] + square[loop.index])
    if first:
        out[0] = q[0]
    return b.finish()


def test_a_cell_that_is_no_product_keeps_the_table() -> None:
    given = {"p": np.arange(4.0) + 2, "q": np.ones(4)}
    for first, work in ((0, ["square"]), (1, [])):
        program = _program(first)
        placed = with_products_in_place(program)
        assert [array.name for array in placed.work] == work
        assert np.array_equal(evaluate(placed, given)["out"], evaluate(program, given)["out"])


def test_a_loop_that_stores_nothing_is_no_table() -> None:
    """A sum over parameters, carried alone, beside a table."""
    b = Builder("some", "")
    p, q, out, square = b.param("p", (4,)), b.input("q", (4,)), b.output("out", (4,)), b.array("square", 4)
    with b.loop("k", 0, 4) as loop:
        square[loop.index] = p[loop.index] * p[loop.index]
    with b.loop("k", 0, 4) as loop:
        total = loop.carry("total", 0)
        loop.follow(total, total + p[loop.index])
    with b.loop("k", 0, 4) as loop:
        out[loop.index] = q[loop.index] * (square[loop.index] * total)
    program, given = b.finish(), {"p": np.arange(4.0) + 2, "q": np.ones(4)}
    placed = with_products_in_place(program)
    assert not placed.work and np.array_equal(evaluate(placed, given)["out"], evaluate(program, given)["out"])
