"""Random expressions: the Program's value in 30 digits is SymPy's, straight, in loops, unrolled and pruned."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from typing import Any

import mpmath
import numpy as np
import pytest
import sympy
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from mpmath import mp

from phichain.errors import EmissionError
from phichain.ir import Program, evaluate, evaluate_exactly, prune, total_operations, unroll
from phichain.ir.builder import Builder
from phichain.ir.from_sympy import from_sympy
from phichain.transform import Block, jacobian

X = sympy.symbols("x0:4")
DIGITS = 30
few = settings(max_examples=40)

leaves = st.one_of(
    st.sampled_from(X),
    st.fractions(-4, 4, max_denominator=12).map(lambda f: sympy.Rational(f.numerator, f.denominator)),
)


def _grown(children: st.SearchStrategy[sympy.Expr]) -> st.SearchStrategy[sympy.Expr]:
    pairs = st.tuples(children, children)
    return st.one_of(
        pairs.map(lambda p: sympy.Add(*p)), pairs.map(lambda p: sympy.Mul(*p)), pairs.map(lambda p: p[0] - p[1]),
        pairs.map(lambda p: p[0] / (1 + p[1] ** 2)), children.map(sympy.sin), children.map(sympy.cos),
        children.map(lambda e: sympy.sqrt(1 + e**2)), children.map(lambda e: -e), children.map(lambda e: e**2),
        st.tuples(st.integers(0, 3), children).map(lambda p: sympy.besselj(p[0], p[1])),
    )  # fmt: skip


expressions = st.recursive(leaves, _grown, max_leaves=8)
points = st.lists(st.fractions(-2, 2, max_denominator=64), min_size=4, max_size=4)


def recorded(*outputs: sympy.Expr) -> Program:
    """out[i] = outputs[i] as a Program in x."""
    b = Builder("f", "")
    x, out = b.input("x", (4,)), b.output("out", (len(outputs),))
    for i, output in enumerate(outputs):
        out[i] = from_sympy(b, output, {X[k]: x[k] for k in range(4)})
    return b.finish()


def at(expression: sympy.Expr, point: list[Fraction]) -> Any:
    """The value that SymPy's own code gives, to the working precision and some more."""
    with mp.workdps(mp.dps + 20):
        return mp.mpmathify(sympy.lambdify(X, expression, "mpmath")(*(mp.mpf(f.numerator) / f.denominator for f in point)))


def exactly(program: Program, point: list[Fraction]) -> list[Any]:
    """The Program's first output at a rational point."""
    with mp.workdps(DIGITS + 20):
        given_point = [mp.mpf(f.numerator) / f.denominator for f in point]
    return next(iter(evaluate_exactly(program, {"x": given_point}, digits=DIGITS + 20).values()))


@few
@given(expressions, points)
def test_a_program_is_its_expression(expression: sympy.Expr, point: list[Fraction]) -> None:
    with mp.workdps(DIGITS):
        expected, (found,) = at(expression, point), exactly(recorded(expression), point)
        assert abs(found - expected) <= mp.mpf(10) ** -25 * (1 + abs(expected))


@few
@given(st.lists(expressions, min_size=2, max_size=3), points)
def test_sharing_pruning_and_unrolling_change_nothing(outputs: list[sympy.Expr], point: list[Fraction]) -> None:
    """Each output alone, all together, pruned and unrolled; together they cost no more than one by one."""
    together = recorded(*outputs)
    alone = [recorded(output) for output in outputs]
    expected = [exactly(program, point)[0] for program in alone]
    for form in (together, prune(together), unroll(together)):
        assert exactly(form, point) == expected
    assert total_operations(together) <= sum(map(total_operations, alone))
    assert total_operations(unroll(together)) <= total_operations(prune(together))


@few
@given(expressions, points)
def test_numpy_and_mpmath_agree(expression: sympy.Expr, point: list[Fraction]) -> None:
    program = recorded(expression)
    (expected,) = exactly(program, point)
    assume(abs(expected) < 1e6)
    single = evaluate(program, {"x": [float(f) for f in point]})["out"][0]
    batch = evaluate(program, {"x": np.tile([float(f) for f in point], (2, 3, 1))})["out"]
    assert batch.shape == (2, 3, 1) and np.all(batch == single)
    slack = 1e-12 * total_operations(program) * (1 + float(abs(expected))) * _growth(expression, point)
    assert abs(single - float(expected)) <= slack


def _growth(expression: sympy.Expr, point: list[Fraction]) -> float:
    """How large intermediate values are: what rounding errors are measured by."""
    sizes = [abs(complex(at(node, point))) for node in sympy.preorder_traversal(expression) if node.is_number or node.args]
    return float(1 + max(sizes, default=0)) ** 2


@few
@given(expressions, points)
def test_derivatives_are_sympys(expression: sympy.Expr, point: list[Fraction]) -> None:
    tangent = jacobian(recorded(expression), "df", "", [Block("out", "x", "slope")])
    with mp.workdps(DIGITS):
        for found, symbol in zip(exactly(tangent, point), X, strict=True):
            expected = at(sympy.diff(expression, symbol), point)
            assert abs(found - expected) <= mp.mpf(10) ** -22 * (1 + abs(expected))


steps: st.SearchStrategy[Callable[[Any, Any], Any]] = st.sampled_from(
    [
        lambda s, t: s + t,
        lambda s, t: s * t - t,
        lambda s, t: t - s * s / 4,
        lambda s, t: (s + 2 * t) / (1 + t * t),
    ]
)


@few
@given(steps, steps, st.integers(1, 6), st.booleans(), st.data())
def test_loops_are_recurrences(
    first: Callable[[Any, Any], Any], second: Callable[[Any, Any], Any], turns: int, backwards: bool, data: st.DataObject
) -> None:
    """Two coupled carried scalars over an array, forwards or backwards, against a plain Python loop."""
    values = data.draw(st.lists(st.fractions(-2, 2, max_denominator=16), min_size=turns, max_size=turns))
    b = Builder("recurrence", "")
    x, out, last = b.input("x", (turns,)), b.output("out", (turns,)), b.output("last", ())
    start, stop, step = (turns - 1, -1, -1) if backwards else (0, turns, 1)
    with b.loop("k", start, stop, step) as loop:
        s, t = loop.carry("s", 1), loop.carry("t", Fraction(1, 2))
        out[loop.index] = b.let("s_now", first(s, x[loop.index]))
        loop.follow(s, first(s, x[loop.index]))
        loop.follow(t, second(t, s))
    last[0] = t
    program = prune(b.finish())
    p, q, expected = Fraction(1), Fraction(1, 2), {}
    for k in range(start, stop, step):
        p, q, expected[k] = first(p, values[k]), second(q, p), first(p, values[k])
    for form in (program, unroll(program)):
        found = evaluate_exactly(form, {"x": [mp.mpf(f.numerator) / f.denominator for f in values]}, digits=60)
        for k, value in expected.items():
            assert abs(found["out"][k] - mp.mpf(value.numerator) / value.denominator) < 1e-10 * (1 + abs(value))
        assert abs(found["last"][0] - mp.mpf(q.numerator) / q.denominator) < 1e-10 * (1 + abs(q))
    _check_loop_tangent(program, values)


def _check_loop_tangent(program: Program, values: list[Fraction]) -> None:
    """The loop form of the tangent pass against the straight form, in 40 digits."""
    blocks = [Block("out", "x", "dout"), Block("last", "x", "dlast")]
    point = {"x": [mpmath.mpf(f.numerator) / f.denominator for f in values]}
    loops, flat = (jacobian(p, "d", "", blocks, keep_outputs=True) for p in (program, unroll(program)))
    found, expected = evaluate_exactly(loops, point, digits=40), evaluate_exactly(flat, point, digits=40)
    for name, entries in expected.items():
        for a, b in zip(found[name], entries, strict=True):
            assert abs(a - b) <= 1e-30 * (1 + abs(b))


def test_an_expression_without_an_operation_is_refused() -> None:
    with pytest.raises(EmissionError, match="exp"):
        recorded(sympy.exp(X[0]))
    with pytest.raises(EmissionError, match="power"):
        recorded(X[0] ** sympy.Rational(1, 3))
