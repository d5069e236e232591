"""How expressions and lines of C are spelt: fewest signs and parentheses, same numbers; broken lines, same words."""

from __future__ import annotations

import math
from collections.abc import Callable
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from phichain.emit.c.layout import WIDTH, aligned, laid_out, laid_out_text
from phichain.emit.c.parts import assignment
from phichain.emit.expressions import Text, double_literal, float_literal, infix
from phichain.errors import EmissionError

OPERATIONS: dict[str, Callable[..., float]] = {
    "add": lambda a, b: a + b, "sub": lambda a, b: a - b, "mul": lambda a, b: a * b,
    "div": lambda a, b: a / b if b else math.nan, "neg": lambda a: -a,
}  # fmt: skip
VARIABLES = {"x": 0.1, "y": -1.7, "z": 3.3e-9}

Expression = tuple[Text, float]


def combined(kind: str, *parts: Expression) -> Expression:
    text = infix(kind, [part[0] for part in parts])
    assert text is not None
    return text, OPERATIONS[kind](*(part[1] for part in parts))


def leaves() -> st.SearchStrategy[Expression]:
    numbers = st.sampled_from([0.5, -0.5, 3.0, -1e-7, 0.1]).map(lambda v: (double_literal(Fraction(v)), v))
    return st.one_of(
        numbers, st.sampled_from(sorted(VARIABLES)).map(lambda name: (Text(name), VARIABLES[name]))
    )


def extended(inner: st.SearchStrategy[Expression]) -> st.SearchStrategy[Expression]:
    binary = st.builds(combined, st.sampled_from(["add", "sub", "mul", "div"]), inner, inner)
    return st.one_of(binary, st.builds(combined, st.just("neg"), inner))


@given(st.recursive(leaves(), extended, max_leaves=20))
def test_an_expression_says_the_same_number_to_the_last_bit(expression: Expression) -> None:
    text, value = expression
    try:
        said = eval(text.text, {"__builtins__": {}}, dict(VARIABLES))
    except ZeroDivisionError:
        return
    assert said == value or math.isnan(value)
    assert not any(signs in text.text for signs in ("--", "+ -", "- -", "((x))"))
    if text.opposite is not None:
        assert text.text.startswith("-")


@pytest.mark.parametrize(
    ("built", "text"),
    [
        (("add", "x", -0.5), "x - 0.5"),
        (("sub", "x", -0.5), "x + 0.5"),
        (("mul", -0.5, "x"), "-0.5 * x"),
        (("mul", "x", -0.5), "x * (-0.5)"),
        (("add", "y", ("mul", -0.5, "x")), "y - 0.5 * x"),
        (("sub", "y", ("mul", -0.5, "x")), "y + 0.5 * x"),
        (("sub", "y", ("neg", ("mul", "x", "z"))), "y + x * z"),
        (("neg", ("neg", "x")), "x"),
        (("neg", ("add", "x", "y")), "-(x + y)"),
        (("mul", ("add", "x", "y"), "z"), "(x + y) * z"),
        (("add", "x", ("add", "y", "z")), "x + (y + z)"),
        (("div", ("mul", "x", "y"), ("mul", "x", "z")), "x * y / (x * z)"),
    ],
)
def test_signs_and_parentheses_are_few(built: Any, text: str) -> None:
    def make(part: Any) -> Text:
        if isinstance(part, float):
            return double_literal(Fraction(part))
        if isinstance(part, str):
            return Text(part)
        made = infix(part[0], [make(argument) for argument in part[1:]])
        assert made is not None
        return made

    assert make(built).text == text


# --- numbers -----------------------------------------------------------------------------------------------------------


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_a_double_literal_is_that_double(value: float) -> None:
    text = double_literal(Fraction(value)).text
    assert float(text) == value
    assert "." in text


@given(st.floats(width=32, allow_nan=False, allow_infinity=False))
def test_a_float_literal_is_that_float(value: float) -> None:
    text = float_literal(Fraction(value)).text
    assert text.endswith("F") and "." in text
    assert np.float32(text[:-1]) == np.float32(value)


@pytest.mark.parametrize("literal", [double_literal, float_literal])
@pytest.mark.parametrize("value", [Fraction(10) ** 400, -(Fraction(10) ** 400), Fraction(1, 10**400)])
def test_a_number_that_does_not_fit_is_refused(literal: Callable[[Fraction], Text], value: Fraction) -> None:
    with pytest.raises(EmissionError, match="does not fit into (double|float)") as caught:
        literal(value)
    assert "units" in caught.value.remedy


def test_a_number_too_large_for_single_precision_names_double() -> None:
    with pytest.raises(EmissionError) as caught:
        float_literal(Fraction(10) ** 39)
    assert 'real = "double"' in caught.value.remedy


# --- lines -------------------------------------------------------------------------------------------------------------

TERMS = st.recursive(
    st.sampled_from(["x", "theta_dot_12", "q[3 * k + 1]", "0.125", "sine_squared[2]"]),
    lambda inner: st.one_of(
        st.builds("{} + {}".format, inner, inner),
        st.builds("{} * {}".format, inner, inner),
        inner.map("({})".format),
    ),
    max_leaves=60,
)


@given(TERMS, st.integers(1, 4))
def test_a_broken_line_has_the_same_words_and_fits(expression: str, depth: int) -> None:
    line = "    " * depth + f"const double t1 = {expression};"
    lines = laid_out(line)
    assert " ".join(part.strip() for part in lines) == line.strip()
    assert all(len(part) <= WIDTH for part in lines)
    assert all(part.startswith("    " * (depth + 1)) for part in lines[1:])
    assert all(part.count("[") == part.count("]") for part in lines)


def test_a_line_is_broken_between_terms_rather_than_inside_one() -> None:
    product = " * ".join(["longer_name_of_a_factor"] * 3)
    assert laid_out(f"    x = {product} + {product};") == [f"    x = {product}", f"        + {product};"]


def test_comments_and_directives_stay_whole() -> None:
    for line in ("/* " + "word " * 40 + "*/", " * " + "word, " * 30, "#define X " + "1 + " * 40 + "1"):
        assert laid_out(line) == [line]


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("sum + x * y", "sum += x * y;"),
        ("sum - (x + y)", "sum -= (x + y);"),
        ("sum + x - y", "sum = sum + x - y;"),
        ("sum * x", "sum = sum * x;"),
        ("sums + x", "sum = sums + x;"),
    ],
)
def test_a_sum_is_added_to_only_where_no_rounding_changes(text: str, line: str) -> None:
    assert assignment("sum", text) == line


def test_columns_stand_below_each_other() -> None:
    assert aligned([("a", "bb", "c"), ("aaa", "b", "")]) == ["a   bb c", "aaa b"]


def test_a_macro_of_long_lines_stays_one_definition() -> None:
    """Every line of a definition but the last ends in a backslash, also where a long line of it was broken."""
    stem = "A_RATHER_LONG_NAME_OF_A_SCENE_FLOWS"
    body = f"    ((lanes)({stem}_KEEP(condition, first_of_both) | {stem}_KEEP(~(condition), second_of_both)))"
    text = f"#define {stem}_CHOOSE(condition, first_of_both, second_of_both) \\\n{body} + \\\n    1\nint after;\n"
    *macro, after = laid_out_text(text).splitlines()
    assert len(macro) == 4 and all(len(line) <= WIDTH for line in macro)
    assert [line.endswith(" \\") for line in macro] == [True, True, True, False]
    assert after == "int after;"
    assert "".join(line.removesuffix("\\") for line in macro).split() == text.replace("\\\n", "").split("int")[0].split()
