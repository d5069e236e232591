"""Programs printed as Python: the text, and that it computes what the Program computes."""

from __future__ import annotations

import math
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import numpy as np
import scipy.special
from hypothesis import given
from hypothesis import strategies as st

from phichain.emit.casadi.python_function import python_function
from phichain.ir.builder import Builder, Expr
from phichain.ir.evaluate import evaluate
from phichain.ir.nodes import Program


def printed(program: Program) -> str:
    tables = {(name, values): f"_{name.upper()}" for name, values in program.tables.items()}
    function = python_function(program, tables, {name: f"_{name}" for name in program.callees})
    head = f"def _{program.name}({', '.join(function.arguments)}):"
    return "\n".join([head, *function.lines])


def callable_of(*programs: Program) -> Callable[..., Any]:
    """The last Program as a Python function on floats; the module `casadi` is not needed for that."""
    names: dict[str, Any] = {
        "casadi": SimpleNamespace(sin=math.sin, cos=math.cos, sqrt=math.sqrt),
        "bessel": lambda x: [float(scipy.special.jv(n, x)) for n in range(5)],
    }
    for program in programs:
        names |= {f"_{name.upper()}": [float(v) for v in values] for name, values in program.tables.items()}
        exec(printed(program), names)  # noqa: S102
    return names[f"_{programs[-1].name}"]  # type: ignore[no-any-return]


def body(program: Program) -> list[str]:
    return printed(program).splitlines()[1:]


def test_a_result_used_once_is_written_where_it_is_used() -> None:
    b = Builder("f", "")
    x, out = b.input("x", (2,)), b.output("out", (1,))
    out[0] = (x[0] + x[1]) * (x[0] - 2 * x[1])
    assert body(b.finish()) == [
        "    out = [None] * 1",
        "    out[0] = (x[0] + x[1]) * (x[0] - 2.0 * x[1])",
        "    return out",
    ]


def test_a_result_used_in_a_loop_is_computed_outside() -> None:
    b = Builder("f", "")
    x, out = b.input("x", (2,)), b.output("out", (3,))
    total = x[0] + x[1]
    with b.loop("k", 0, 3) as loop:
        out[loop.index] = total / x[0]
    lines = body(b.finish())
    assert lines.index("    t1 = x[0] + x[1]") < lines.index("    for k in range(3):")


def test_named_quantities_keep_their_names_and_python_words_give_way() -> None:
    b = Builder("f", "")
    x, out = b.input("lambda", ()), b.output("out", ())
    tension = b.let("tension", x[0] * x[0])
    out[0] = b.let("range", tension + 1) * tension
    assert body(b.finish()) == [
        "    tension = lambda_ * lambda_",
        "    range_ = tension + 1.0",
        "    out = range_ * tension",
        "    return out",
    ]
    assert callable_of(b.finish())(3.0) == 90.0


def test_carried_values_move_on_together() -> None:
    """Fibonacci numbers: the second move must still see the first one's old value."""
    b = Builder("f", "")
    start, out = b.input("start", ()), b.output("out", ())
    with b.loop("k", 0, 9) as loop:
        older, newer = loop.carry("older", 0), loop.carry("newer", start[0])
        following = older + newer
        loop.follow(older, newer)
        loop.follow(newer, following)
    out[0] = newer
    assert callable_of(b.finish())(1.0) == 55.0


def test_loops_run_backwards_and_inside_one_another() -> None:
    b = Builder("f", "")
    x, out = b.input("x", (4,)), b.output("out", (4,))
    with b.loop("i", 3, -1, -1) as outer:
        with b.loop("j", outer.index + 1, 4) as inner:
            total = inner.carry("total", x[outer.index])
            inner.follow(total, 2 * total + x[inner.index])
        out[outer.index] = total
    program = b.finish()
    x_values = np.array([1.0, -2.0, 0.5, 3.0])
    assert callable_of(program)(x_values.tolist()) == evaluate(program, {"x": x_values})["out"].tolist()


def test_a_loop_in_which_nothing_happens_leaves_no_text() -> None:
    b = Builder("f", "")
    x, out = b.input("x", ()), b.output("out", ())
    with b.loop("k", 0, 3) as loop:
        same = loop.carry("same", x[0])
    out[0] = same
    assert body(b.finish()) == ["    same = x", "    out = same", "    return out"]


def test_sines_of_part_of_an_array_and_room_beyond_them() -> None:
    b = Builder("f", "")
    q, out = b.input("q", (4,)), b.output("out", (3,))
    sine, cosine = b.sincos(q.shifted(1), 2, padding=1)
    sine[2] = b.lift(7)
    out[0], out[1], out[2] = sine[0] + cosine[0], sine[1] + cosine[1], sine[2]
    program = b.finish()
    assert "    sine[:2] = [casadi.sin(angle) for angle in q[1:3]]" in body(program)
    expected = [math.sin(2) + math.cos(2), math.sin(3) + math.cos(3), 7.0]
    assert callable_of(program)([1.0, 2.0, 3.0, 4.0]) == expected


def test_bessel_functions_of_one_argument_share_a_call_in_their_block_alone() -> None:
    b = Builder("f", "")
    x, out = b.input("x", (2,)), b.output("out", (4,))
    for block in (0, 2):
        with b.loop("k", 0, 2) as loop:
            k = loop.index
            out[k + block] = b.apply("besselj0", x[k]) + (block + 1) * b.apply("besselj3", x[k])
    program = b.finish()
    assert printed(program).count("= bessel(x[k])") == 2
    x_values = np.array([0.4, 2.5])
    expected = evaluate(program, {"x": x_values})["out"]
    assert np.allclose(callable_of(program)(x_values.tolist()), expected, rtol=1e-15)


def test_calls_hand_on_the_parameters() -> None:
    callee = Builder("scaled", "")
    factor, x, y = callee.param("factor", ()), callee.input("x", (2,)), callee.output("y", (2,))
    y[0], y[1] = factor[0] * x[1], factor[0] * x[0]
    b = Builder("twice", "")
    b.param("factor", ())
    z, out = b.input("z", (2,)), b.output("out", (2,))
    inner = callee.finish()
    (once,) = b.call(inner, [z], {"once": 2})
    (again,) = b.call(inner, [once], {"again": 2})
    out[0], out[1] = again[0], again[1]
    program = b.finish()
    assert "    once = _scaled(factor, z)" in body(program)
    assert callable_of(inner, program)(3.0, [1.0, 2.0]) == [9.0, 18.0]


@given(st.data())
def test_random_expressions_come_out_as_they_went_in(data: st.DataObject) -> None:
    b = Builder("f", "")
    x, out = b.input("x", (3,)), b.output("out", (2,))
    values: list[Expr] = [x[0], x[1], x[2], b.lift(0.75), b.lift(-2)]
    for _ in range(data.draw(st.integers(1, 25))):
        kind = data.draw(st.sampled_from(["add", "sub", "mul", "neg", "sin", "cos"]))
        count = 2 if kind in ("add", "sub", "mul") else 1
        args = [data.draw(st.sampled_from(values)) for _ in range(count)]
        values.append(b.apply(kind, *args))
    out[0], out[1] = values[-1], data.draw(st.sampled_from(values))
    program = b.finish()
    given_x = np.array([0.3, -1.1, 0.9])
    expected = evaluate(program, {"x": given_x})["out"]
    actual = callable_of(program)(given_x.tolist())
    assert np.allclose(actual, expected, rtol=1e-13, atol=1e-13 * (1 + np.max(np.abs(expected))))
