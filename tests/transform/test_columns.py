"""Programs for several columns at once against the Program itself, column by column."""

from __future__ import annotations

import numpy as np
import pytest

from phichain.emit.flow.propagate import flow_program
from phichain.errors import EmissionError
from phichain.ir.builder import Builder
from phichain.ir.evaluate import evaluate
from phichain.ir.nodes import For, Program, walk
from phichain.mechanics import derive
from phichain.transform.columns import LONGEST_RUN, columns
from phichain.transform.jets import jets
from phichain.transform.lanes import SUMS
from tests.flow.flows import planar, scene

WIDTH = 3
CHAINS = {
    "short": planar(2),
    "looped": planar(4, "looped", target={"code": "loops"}),
    "tips": scene("tips", "planar", "cart", links=3, mass=[1, 2, 0.5], length=1, cart_mass=0.7),
    "spatial": scene("spatial", "spatial", "cart", links=2, mass=0.1, length=[0.1, 0.3], cart_mass=0.5),
}


def assert_same(program: Program, wide: set[str]) -> None:
    random = np.random.default_rng(5)
    arrays = [*program.params, *program.inputs]
    given = {array.name: random.uniform(0.5, 1.5, (WIDTH, array.size)) for array in arrays}
    for array in arrays:
        if array.name not in wide:
            given[array.name][:] = given[array.name][0]
    together = columns(program, WIDTH, [array.name for array in program.inputs if array.name not in wide])
    side_by_side = {name: rows.T.ravel() if name in wide else rows[0] for name, rows in given.items()}
    found = evaluate(
        together, {name: shaped(together, name, values) for name, values in side_by_side.items()}
    )
    for column in range(WIDTH):
        alone = {name: shaped(program, name, rows[column]) for name, rows in given.items()}
        for name, expected in evaluate(program, alone).items():
            mine = np.ravel(found[name]).reshape(-1, WIDTH)[:, column]
            assert mine.tolist() == np.ravel(expected).tolist(), name


def shaped(program: Program, name: str, values: np.ndarray) -> np.ndarray:
    shape = next(array.shape for array in (*program.params, *program.inputs) if array.name == name)
    return values.reshape(shape)


@pytest.mark.parametrize("name", CHAINS)
def test_sweeps_of_a_flow(name: str) -> None:
    assert_same(jets(flow_program(derive(CHAINS[name]))).follow, {"q", "v", SUMS})


def test_long_runs_are_cut_and_values_cross_the_cuts() -> None:
    builder = Builder("long", "")
    q, shift, out = builder.input("q", (2,)), builder.input("shift", ()), builder.output("out", (2,))
    first = builder.let("first", q[0] * q[1])
    value = q[0]
    for _ in range(2 * LONGEST_RUN):
        value = value * q[1] + shift[0]
        value = builder.sqrt(value)
    out[0], out[1] = value, first * value
    program = builder.finish()
    assert_same(program, {"q"})
    runs = [s for s in walk(columns(program, WIDTH, ["shift"]).body) if isinstance(s, For)]
    assert len(runs) >= 4 and max(len(run.body) for run in runs) <= 2 * LONGEST_RUN


def test_carried_scalars_of_nested_loops_both_ways() -> None:
    builder = Builder("nested", "")
    q, out, last = builder.input("q", (4,)), builder.output("out", (4,)), builder.output("last", ())
    with builder.loop("k", 0, 4) as up:
        before, total = up.carry("before", q[3]), up.carry("total", 1)
        with builder.loop("j", 3, -1, -1) as down:
            inner = down.carry("inner", before)
            down.follow(inner, inner * q[down.index] + total)
        out[up.index] = inner
        up.follow(total, inner + before)
        up.follow(before, total)
    last[0] = total * before
    assert_same(builder.finish(), {"q"})


def test_a_loop_that_never_turns_hands_on_its_initial_value() -> None:
    builder = Builder("empty", "")
    q, out = builder.input("q", (1,)), builder.output("out", ())
    with builder.loop("k", 0, 0) as loop:
        total = loop.carry("total", q[0])
        loop.follow(total, total * 2)
    out[0] = total + 1
    assert_same(builder.finish(), {"q"})


def test_what_is_no_operation_is_refused() -> None:
    builder = Builder("turning", "")
    q = builder.input("q", (2,))
    sine, _ = builder.sincos(q, 2)
    builder.output("out", (1,))[0] = sine[0]
    with pytest.raises(EmissionError, match="SinCos"):
        columns(builder.finish(), WIDTH, [])
