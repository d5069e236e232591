"""Cells that nothing reads, and arrays that hold the same: left out without a difference in any result."""

from __future__ import annotations

from contextlib import ExitStack
from fractions import Fraction

import numpy as np
import pytest

from phichain.ir.builder import Builder
from phichain.ir.evaluate import evaluate
from phichain.ir.nodes import Program, Store, walk
from phichain.transform.twins import without_twins
from phichain.transform.unread import without_unread_cells

X = np.array([0.3, -1.2, 0.7, 2.5])


def same(before: Program, after: Program) -> bool:
    first, second = (evaluate(program, {"x": X}) for program in (before, after))
    return all(np.array_equal(first[name], second[name]) for name in first)


def padded() -> Program:
    """`wide` has a cell before and two behind those that are read; `out` is a result that is read, too."""
    builder = Builder("padded", "Padded.")
    x, out = builder.input("x", (4,)), builder.output("out", (4,))
    wide = builder.array("wide", 7)
    wide[0], wide[5], wide[6] = builder.lift(1), builder.lift(2), builder.lift(3)
    with builder.loop("i", 1, 5) as loop:
        wide[loop.index] = x[loop.index - 1] * 2
    out[0] = wide[1] + wide[2]
    with builder.loop("k", 1, 4) as loop:
        out[loop.index] = out[0] * wide[loop.index + 1]
    return builder.finish()


def doubled(order: tuple[str, str] = ("first", "second"), factor: int = 1) -> Program:
    """Two arrays of the same values, and a copy of the input's; `factor` makes one of the values differ."""
    builder = Builder("doubled", "Doubled.")
    x, out = builder.input("x", (4,)), builder.output("out", (4,))
    arrays = {name: builder.array(name, 4) for name in ("first", "second", "copy", "square")}
    with builder.loop("i", 0, 4) as loop:
        value = builder.let("value", x[loop.index] * x[loop.index])
        arrays[order[0]][loop.index] = value
        arrays[order[1]][loop.index] = value * factor
        arrays["square"][loop.index] = value + 1
    with builder.loop("j", 0, 4) as loop:
        arrays["copy"][loop.index] = arrays["square"][loop.index]
    with builder.loop("k", 0, 4) as loop:
        k = loop.index
        out[k] = arrays["first"][k] + arrays["second"][k] * Fraction(1, 3) + arrays["copy"][k] * arrays["square"][k]
    return builder.finish()


def test_cells_that_nothing_reads_are_not_written() -> None:
    before, after = padded(), without_unread_cells(padded())
    assert same(before, after)
    assert [array.size for array in before.work] == [7] and [array.size for array in after.work] == [5]
    stores = [statement.cell.array for statement in walk(after.body) if isinstance(statement, Store)]
    assert stores.count("wide") == 1 and stores.count("out") == 2
    assert without_unread_cells(after) == after


def test_arrays_that_hold_the_same_are_one() -> None:
    for order, kept in ((("first", "second"), "first"), (("second", "first"), "second")):
        before, after = doubled(order), without_twins(doubled(order))
        assert same(before, after)
        assert {array.name for array in after.work} == {kept, "square"}


def test_arrays_that_differ_in_one_value_stay_two() -> None:
    before, after = doubled(factor=2), without_twins(doubled(factor=2))
    assert same(before, after) and {array.name for array in after.work} == {"first", "second", "square"}


@pytest.mark.parametrize(("depth", "kept"), [(2, set()), (3, {"beside"})])
def test_copies_of_sines_stay_where_loops_three_deep_read_them(depth: int, kept: set[str]) -> None:
    """There a pointer less counts; elsewhere a copy is what it copies."""
    builder = Builder("copied", "Copies sines.")
    x, out = builder.input("x", (4,)), builder.output("out", (4,))
    sine, _ = builder.sincos(x, 4)
    beside = builder.array("beside", 4)
    with builder.loop("k", 0, 4) as loop:
        beside[loop.index] = sine[loop.index]
    with ExitStack() as loops:
        index = [loops.enter_context(builder.loop(name, 0, 4)).index for name in "abc"[:depth]][-1]
        out[index] = beside[index] * 2
    before = builder.finish()
    after = without_twins(before)
    assert same(before, after) and {array.name for array in after.work} - {"sine", "cosine"} == kept
