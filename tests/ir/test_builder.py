"""What the builder records: exact numbers, shared values, structural zeros, names, loops."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest

from phichain.errors import ArrayError
from phichain.ir import evaluate, evaluate_exactly, prune, total_operations, unroll
from phichain.ir.builder import Builder, Expr
from phichain.ir.nodes import Op, Program, walk


def operations(program: Program) -> list[str]:
    """The kinds of the operations in their order."""
    return [statement.kind for statement in walk(program.body) if isinstance(statement, Op)]


def built(*values: str) -> Program:
    """Outputs out[i] = values[i], written in terms of x[0], x[1], x[2] and the builder b."""
    b = Builder("f", "")
    x, out = b.input("x", (3,)), b.output("out", (len(values),))
    for i, text in enumerate(values):
        out[i] = eval(text, {"b": b, "x": x, "Fraction": Fraction})
    return b.finish()


def test_numbers_are_exact() -> None:
    """0.1 and 0.2 are the binary fractions they are, and a third stays a third until it is printed."""
    b = Builder("f", "")
    assert (b.lift(0.1) + b.lift(0.2)).constant == Fraction(0.1) + Fraction(0.2)
    assert (b.lift(1) / 3 * 3).constant == 1
    third = evaluate_exactly(built("x[0] / 3"), {"x": [1, 0, 0]}, digits=50)["out"][0]
    assert abs(third * 3 - 1) < 1e-49


@pytest.mark.parametrize(
    ("text", "kinds"),
    [
        ("x[0] + 0", []), ("x[0] - 0", []), ("x[0] * 1", []), ("x[0] / 1", []), ("-(-x[0])", []), ("x[0] - x[0]", []),
        ("0 - x[0]", ["neg"]), ("x[0] * -1", ["neg"]), ("x[0] + (-x[1])", ["sub"]), ("-(x[0] - x[1])", ["sub"]),
        ("(-x[0]) * (-x[1])", ["mul"]), ("2 * (3 * x[0])", ["mul"]), ("x[0] / 2", ["mul"]), ("b.sin(b.lift(0))", []),
        ("b.cos(b.lift(0))", []), ("b.sqrt(b.lift(1))", []), ("b.lift(0) / x[0]", []), ("b.lift(0) * x[0]", []),
        ("b.apply('besselj0', 0)", []), ("x[0] / x[0]", ["div"]), ("x[0] * x[0]", ["mul"]),
    ],
)  # fmt: skip
def test_trivial_operations_are_left_out(text: str, kinds: list[str]) -> None:
    assert operations(prune(built(text))) == kinds


def test_constant_factors_merge() -> None:
    assert evaluate(prune(built("2 * (3 * x[0])")), {"x": [7.0, 0, 0]})["out"].tolist() == [42.0]


def test_equal_values_are_computed_once() -> None:
    program = built("x[0] * x[1] + x[2]", "x[2] + x[1] * x[0]", "b.sin(x[0]) - b.sin(x[0] + 0)")
    assert operations(program) == ["mul", "add", "sin"]


def test_only_structural_zeros_disappear() -> None:
    """What is zero at run time stays in the product, so that NaN and infinity are passed on."""
    program = built("x[0] * x[1]", "b.lift(0) * x[0]", "x[0] - x[0]")
    out = evaluate(program, {"x": [math.nan, 0.0, 0.0]})["out"]
    assert np.isnan(out[0]) and out[1] == 0 and out[2] == 0
    assert np.isnan(evaluate(built("x[0] * x[1]"), {"x": [math.inf, 0.0, 0.0]})["out"][0])


def test_sums_are_not_reassociated() -> None:
    out = evaluate(built("(x[0] + x[1]) - x[0]"), {"x": [1e17, 1.0, 0.0]})["out"]
    assert out[0] == (1e17 + 1.0) - 1e17 == 0.0


def test_a_name_reaches_handles_taken_before_it() -> None:
    """A value named after another handle to it was taken keeps both handles valid."""
    b = Builder("f", "")
    x, out = b.input("x", (2,)), b.output("out", (2,))
    early = x[0] * x[1]
    named = b.let("product", x[1] * x[0])
    out[0], out[1] = early + 1, named + 2
    program = unroll(b.finish())
    assert evaluate(program, {"x": [3.0, 5.0]})["out"].tolist() == [16.0, 17.0]
    assert "product = mul(x[0], x[1])" in str(b.finish())


def test_the_first_name_stays() -> None:
    b = Builder("f", "")
    x = b.input("x", (2,))
    first = b.let("first", x[0] + x[1])
    assert b.let("second", first).operand == first.operand
    assert b.let("alone", x[0]).operand == x[0].operand


def test_loops_carry_and_unroll() -> None:
    """Horner's scheme with a table of exact coefficients, its initial value computed before the loop."""
    b = Builder("horner", "")
    x, out = b.input("x", ()), b.output("out", ())
    coefficients = b.table("coefficients", 5, lambda k: Fraction(1, 3) if k == 2 else Fraction(2))
    with b.loop("k", 3, -1, -1) as loop:
        value = loop.carry("value", coefficients[4] + b.lift(0))
        loop.follow(value, value * x[0] + coefficients[loop.index])
    out[0] = value
    program = b.finish()
    expected = np.polyval([2, 2, 1 / 3, 2, 2], 1.7)
    for form in (program, unroll(program)):
        assert evaluate(form, {"x": 1.7})["out"] == pytest.approx(expected, rel=1e-15)
    assert total_operations(program) == 8
    assert unroll(program).is_straight_line and not program.is_straight_line


def test_initial_values_leave_the_loop() -> None:
    b = Builder("f", "")
    x, out = b.input("x", (2,)), b.output("out", ())
    with b.loop("k", 0, 2) as loop:
        total = loop.carry("total", (x[0] + x[1]) * x[1])
        loop.follow(total, total + x[loop.index])
    out[0] = total
    program = b.finish()
    assert evaluate(program, {"x": [2.0, 3.0]})["out"] == 20.0
    assert operations(program) == ["add", "mul", "add"]
    assert total_operations(program) == 4


def test_nested_loops_run_in_triangles() -> None:
    b = Builder("f", "")
    out = b.output("out", (3, 3))
    with b.loop("k", 0, 3) as rows, b.loop("k", rows.index, 3) as columns:
        out[rows.index * 3 + columns.index] = b.lift(1)
    with b.loop("i", 0, 3) as rows, b.loop("j", 0, rows.index) as columns:
        out[rows.index * 3 + columns.index] = b.lift(2)
    found = evaluate(b.finish(), {})["out"]
    assert found.tolist() == [[1, 1, 1], [2, 1, 1], [2, 2, 1]]


def test_pruning_drops_what_no_output_needs() -> None:
    b = Builder("f", "")
    x, out = b.input("x", (4,)), b.output("out", ())
    unused = b.array("unused", 4)
    with b.loop("k", 0, 4) as loop:
        kept, lost = loop.carry("kept", 0), loop.carry("lost", 1)
        unused[loop.index] = lost * x[loop.index]
        loop.follow(kept, kept + x[loop.index])
        loop.follow(lost, lost * x[loop.index])
    b.sin(x[0])
    out[0] = kept
    program = prune(b.finish())
    assert total_operations(program) == 4 and program.work == ()
    assert "lost" not in str(program) and "sin" not in str(program)
    assert evaluate(program, {"x": [1.0, 2.0, 3.0, 4.0]})["out"] == 10.0


def test_complex_and_wrong_arguments() -> None:
    program = built("b.sqrt(x[0]) * b.sin(x[1]) / x[2]")
    derivative = evaluate(program, {"x": np.array([2.0, 0.3 + 1e-30j, 5.0])})["out"].imag / 1e-30
    assert derivative[0] == pytest.approx(math.sqrt(2) * math.cos(0.3) / 5, rel=1e-15)
    with pytest.raises(ArrayError, match="x"):
        evaluate(program, {})
    with pytest.raises(ArrayError, match="x"):
        evaluate(program, {"x": np.zeros(2)})


def test_a_program_reads() -> None:
    """print(program) shows names, loops with their carried scalars, and numbers a reader can check."""
    b = Builder("swing", "")
    theta, out = b.input("theta", (2,)), b.output("torque", (2,))
    sine, _ = b.sincos(theta, 2)
    with b.loop("k", 1, -1, -1) as loop:
        beyond = loop.carry("beyond", 0)
        pull = b.let("pull", Fraction(981, 100) * sine[loop.index])
        out[loop.index] = b.let("moment", pull + beyond)
        loop.follow(beyond, pull)
    assert str(b.finish()).splitlines() == [
        "swing(theta) -> torque",
        "  sine, cosine = sincos(theta[0:2])",
        "  for k in range(1, -1, -1):",
        "    carry beyond: 0 -> pull",
        "    pull = mul(9.8100000000000005, sine[k])",
        "    moment = add(pull, beyond)",
        "    torque[k] = moment",
    ]


def test_handles_show_what_is_known() -> None:
    b = Builder("f", "")
    x = b.input("x", (2,))
    assert isinstance(x[0], Expr) and x[0].constant is None and not x[0].is_zero
    assert (x[0] * 0).is_zero
    assert x.shifted(1)[0].operand == x[1].operand
