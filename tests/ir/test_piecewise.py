"""select and floor in every algebra: NumPy, mpmath, exact constants, loops and straight lines, C, CasADi, tangents, patterns."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mpmath import mp

from phichain.emit.c.lanes import lane_function
from phichain.emit.c.names import CNames
from phichain.emit.casadi.python_function import python_function
from phichain.errors import EmissionError
from phichain.ir import Program, count_operations, evaluate, evaluate_exactly, unroll
from phichain.ir.builder import Builder, Expr
from phichain.ir.piecewise import floor, maximum, minimum, wrapped
from phichain.ir.varying import varying
from phichain.transform import Block, jacobian
from phichain.transform.pattern import jacobian_pattern
from tests.one_program import c_text, compiled

numbers = st.floats(-20, 20)
POINTS = [(0.3, -0.7), (-0.7, 0.3), (5.5, 5.5), (-3.0, 2.0), (7.25, -11.5), (0.0, 1.0)]


def reference(x: Any, y: Any, whole: Any) -> list[Any]:
    """What `everything` computes, on plain numbers."""
    return [min(x, y), max(x, y), whole(x), x - 3 * whole(x / 3 + Fraction(1, 2)), max(min(x * y, 4), -2), min(x, y) * whole(y)]


def everything() -> Program:
    b = Builder("everything", "")
    x, out = b.input("x", (2,)), b.output("out", (6,))
    least: Expr = minimum(x[0], x[1])
    results = [least, maximum(x[0], x[1]), floor(x[0]), wrapped(x[0], Fraction(3))]
    results += [maximum(minimum(x[0] * x[1], 4), -2), least * floor(x[1])]
    for k, value in enumerate(results):
        out[k] = value
    return b.finish()


@given(numbers, numbers)
def test_numpy_and_mpmath_are_pythons_own(x: float, y: float) -> None:
    expected = reference(x, y, lambda value: float(math.floor(value)))
    assert evaluate(everything(), {"x": [x, y]})["out"].tolist() == pytest.approx(expected, rel=1e-15, abs=1e-15)
    with mp.workdps(50):
        exact = _exact(x, y)
        found = evaluate_exactly(everything(), {"x": [x, y]}, digits=50)["out"]
        assert all(abs(a - b) < mp.mpf(10) ** -45 for a, b in zip(found, exact, strict=True))


def _exact(x: float, y: float) -> list[Any]:
    found = reference(Fraction(x), Fraction(y), lambda value: Fraction(math.floor(value)))
    return [mp.mpf(value.numerator) / value.denominator for value in map(Fraction, found)]


def test_batches_and_straight_lines() -> None:
    batch = evaluate(everything(), {"x": np.array(POINTS)})["out"]
    for row, point in zip(batch, POINTS, strict=True):
        assert row.tolist() == evaluate(unroll(everything()), {"x": point})["out"].tolist()


def test_constants_are_decided_when_the_program_is_written() -> None:
    b = Builder("constants", "")
    x, out = b.input("x", ()), b.output("out", (4,))
    known = [b.lift(Fraction(7, 2)), b.lift(-2)]
    out[0], out[1] = minimum(known[0], -2), maximum(known[1], Fraction(7, 2))
    out[2], out[3] = floor(b.lift(Fraction(-1, 3))), b.apply("select", x[0], 1, x[0], x[0])
    program = b.finish()
    assert not count_operations(program)
    assert evaluate(program, {"x": 5.0})["out"].tolist() == [-2, 3.5, -1, 5]


@pytest.mark.parametrize("real", ["double", "float"])
def test_c_computes_the_same_and_passes_nan(real: str, tmp_path) -> None:
    call = compiled(everything(), tmp_path, real)
    assert ("floorf(" if real == "float" else "floor(") in c_text(everything(), real)
    for x, y in POINTS:
        expected = reference(x, y, lambda value: float(math.floor(value)))
        assert call([x, y])["out"].tolist() == pytest.approx(expected, rel=1e-6 if real == "float" else 1e-15, abs=1e-6)
    assert np.isnan(call([np.nan, 1.0])["out"]).tolist() == [True, True, True, True, True, True]
    assert np.isnan(evaluate(everything(), {"x": [np.nan, 1.0]})["out"]).all()


def test_no_sum_is_taken_into_a_condition(tmp_path) -> None:
    """`total = total + x < 1 ? ..` must not become `total += ..`: the choice stands in brackets."""
    b = Builder("sums", "")
    x, out = b.input("x", (3,)), b.output("out", ())
    with b.loop("k", 0, 3) as loop:
        total = loop.carry("total", 0)
        loop.follow(total, b.apply("select", total + x[loop.index], 1, x[loop.index], 0))
    out[0] = total
    program = b.finish()
    call = compiled(program, tmp_path)
    for given_x in ([0.5, 0.25, 0.125], [0.75, 0.5, -0.5]):
        total_now = 0.0
        for value in given_x:
            total_now = value if total_now + value < 1.0 else 0.0
        assert call(given_x)["out"][0] == total_now == evaluate(program, {"x": given_x})["out"]


def test_casadi_computes_the_same() -> None:
    casadi = pytest.importorskip("casadi")
    printed = python_function(everything(), {}, {})
    names: dict[str, Any] = {"casadi": casadi}
    exec("\n".join([f"def f({', '.join(printed.arguments)}):", *printed.lines]), names)  # noqa: S102
    for kind in (casadi.SX, casadi.MX):
        x = kind.sym("x", 2)
        function = casadi.Function("f", [x], [casadi.vertcat(*names["f"]([x[0], x[1]]))])
        for point in POINTS:
            found = np.asarray(function(point)).ravel()
            assert found.tolist() == evaluate(everything(), {"x": point})["out"].tolist()
        assert np.isnan(np.asarray(function([np.nan, 1.0]))).all()


@pytest.mark.parametrize("form", ["straight", "loops"])
def test_tangents_follow_the_branch_that_is_taken(form: str) -> None:
    if form == "straight":
        program, size = everything(), 6
    else:
        b = Builder("looped", "")
        x, out = b.input("x", (2,)), b.output("out", (2,))
        with b.loop("k", 0, 2) as loop:
            out[loop.index] = maximum(minimum(x[loop.index] * x[1], 4), -2) + x[0] * floor(x[loop.index])
        program, size = b.finish(), 2
    tangent = jacobian(program, "tangent", "", [Block("out", "x", "slope")])
    assert tangent.is_straight_line == (form == "straight")
    for point in [(0.3, -0.7), (-0.7, 0.3), (7.25, -11.5), (1.2, 1.3)]:
        found = evaluate(tangent, {"x": point})["slope"]
        expected = np.empty((size, 2))
        with mp.workdps(50):
            for column in range(2):
                ends = []
                for sign in (1, -1):
                    moved = [mp.mpf(value) for value in point]
                    moved[column] += sign * mp.mpf(10) ** -20
                    ends.append(evaluate_exactly(program, {"x": moved}, digits=50)["out"])
                expected[:, column] = [float((a - b) / (2 * mp.mpf(10) ** -20)) for a, b in zip(*ends, strict=True)]
        assert np.allclose(found, expected, rtol=1e-14, atol=1e-14)
        stepped = evaluate(program, {"x": np.array(point) + np.array([1e-30j, 0])})["out"].imag / 1e-30
        assert np.allclose(stepped, expected[:, 0], rtol=1e-14, atol=1e-14)


def test_patterns_and_dependences() -> None:
    program = everything()
    moving = jacobian_pattern(program)["out", "x"]
    assert moving == ((0, 0), (0, 1), (1, 0), (1, 1), (3, 0), (4, 0), (4, 1), (5, 0), (5, 1))
    assert {"out", "x"} <= varying(program, ["x"])


def test_what_has_no_form_for_them_says_so() -> None:
    b = Builder("field", "")
    q, v = b.input("q", (1,)), b.input("v", (1,))
    b.output("a", (1,))[0] = minimum(q[0], v[0])
    program = b.finish()
    with pytest.raises(EmissionError, match="has no form on vectors"):
        lane_function(program, CNames("one", "double", {}), "two")


@pytest.mark.parametrize("real", ["double", "float"])
def test_arithmetic_rounded_once_knows_them(real: str) -> None:
    from phichain.ir.interpret import run
    from phichain.ir.rounded import arithmetic

    # Sums, products and wholes of these are exact in either type, and so are thirds of whole multiples of three.
    found = run(everything(), arithmetic(real), {"x": [4.5, -3.25]})["out"]
    assert found == pytest.approx(_floats(4.5, -3.25), rel=1e-15 if real == "double" else 1e-6)
    broken = run(everything(), arithmetic(real), {"x": [math.nan, 1.0]})["out"]
    assert all(math.isnan(value) for value in broken)


def _floats(x: float, y: float) -> list[float]:
    return [float(value) for value in reference(x, y, lambda value: float(math.floor(value)))]
