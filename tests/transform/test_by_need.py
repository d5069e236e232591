"""Straight-line code in the order of its need: the same values to the last bit, fewer of them in use at once."""

from __future__ import annotations

import numpy as np
import pytest

from phichain.ir.builder import Builder
from phichain.ir.evaluate import evaluate
from phichain.ir.nodes import Local, Op, Program, Store
from phichain.transform.by_need import in_order_of_need, most_alive


def scattered(seed: int, angles: int) -> Program:
    """Random sums and products, computed in no order that their results would ask for; some of sines."""
    source, builder = np.random.default_rng(seed), Builder("scattered", "")
    q, u, out = builder.input("q", (angles,)), builder.input("u", (6,)), builder.output("out", (3,))
    values = [u[k] * (k + 2) for k in range(6)]
    values += [builder.sin(q[k]) for k in range(angles)] + [builder.cos(q[k]) for k in range(angles)]
    for _ in range(40):
        one, other = (values[source.integers(len(values))] for _ in range(2))
        values.append([one + other, one * other, one - 2 * other][source.integers(3)])
    values.append(builder.sin(values[-1]))
    for k in range(3):
        out[k] = values[-1 - 7 * k]
    return builder.finish()


@pytest.mark.parametrize("angles", [1, 2, 4])
@pytest.mark.parametrize("seed", range(4))
def test_values_are_the_same_and_no_more_are_in_use(seed: int, angles: int) -> None:
    program = scattered(seed, angles)
    ordered, source = in_order_of_need(program), np.random.default_rng(seed)
    given = {"q": source.uniform(-3.0, 3.0, angles), "u": source.uniform(-2.0, 2.0, 6)}
    assert np.array_equal(evaluate(ordered, given)["out"], evaluate(program, given)["out"])
    assert most_alive(ordered.body) <= most_alive(program.body)
    known = set[str]()
    for statement in ordered.body:
        args = statement.args if isinstance(statement, Op) else (statement.value,) if isinstance(statement, Store) else ()
        assert {arg.name for arg in args if isinstance(arg, Local)} <= known
        known |= {statement.result} if isinstance(statement, Op) else set()


def test_what_is_used_last_is_computed_last() -> None:
    """Products of inputs made up front wait in registers for their turn; each comes right before its sum."""
    builder = Builder("sums", "")
    u, out = builder.input("u", (8,)), builder.output("out", (1,))
    products = [u[k] * u[k] for k in range(8)]
    total = products[0]
    for product in products[1:]:
        total = total + product
    out[0] = total
    program = builder.finish()
    ordered = in_order_of_need(program)
    assert [op.kind for op in ordered.body[:5] if isinstance(op, Op)] == ["mul", "mul", "add", "mul", "add"]
    assert most_alive(ordered.body) == 2 < most_alive(program.body) == 8


@pytest.mark.parametrize(("angles", "first"), [(2, "sin"), (3, "mul")])
def test_what_else_is_read_comes_after_the_sines_of_few_angles(angles: int, first: str) -> None:
    builder = Builder("turned", "")
    q, u, out = builder.input("q", (angles,)), builder.input("u", (angles,)), builder.output("out", (angles,))
    pushes = [3 * u[k] for k in range(angles)]
    for k in range(angles):
        out[k] = builder.sin(q[k]) * pushes[k]
    (start, *_) = in_order_of_need(builder.finish()).body
    assert isinstance(start, Op) and start.kind == first


def test_the_better_order_stays() -> None:
    """A product and a sum that take up cells in turn hold one cell at a time; one after the other they would hold all."""
    builder = Builder("in_turn", "")
    u, out = builder.input("u", (6,)), builder.output("out", (2,))
    product, total = u[0] * u[1], u[0] + u[1]
    for k in range(2, 6):
        product, total = product * u[k], total + u[k]
    out[0], out[1] = product, total
    program = builder.finish()
    assert in_order_of_need(program).body == program.body and most_alive(program.body) < 6


def test_loops_stay_as_they_are() -> None:
    builder = Builder("looped", "")
    u, out = builder.input("u", (4,)), builder.output("out", (4,))
    with builder.loop("k", 0, 4) as loop:
        out[loop.index] = 2 * u[loop.index]
    program = builder.finish()
    assert in_order_of_need(program) is program
