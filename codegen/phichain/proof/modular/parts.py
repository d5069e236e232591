"""A value with its derivatives as texts: how sums and products of such values are written.

A value is written as up to four variables, marked "" (itself), "a", "b" (derivatives along two directions) and "m" (along both); those
that are structurally zero are left out.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Final

from phichain.ir.nodes import Affine
from phichain.proof.modular.field import PRIME

MARKS: Final = ("", "a", "b", "m")

Parts = dict[str, str]
"""What a value and its derivatives are called, by mark."""


def index_text(index: Affine) -> str:
    """An index as Python."""
    terms = [f"I_{variable}" if factor == 1 else f"{factor} * I_{variable}" for variable, factor in index.terms]
    return " + ".join([*terms, *([str(index.offset)] if index.offset or not terms else [])])


def added(values: list[Parts], kind: str) -> Parts:
    """x + y, x - y or -x."""
    if kind == "neg":
        return {mark: f"-{text}" for mark, text in values[0].items()}
    a, b = values
    sign, made = {"add": "+", "sub": "-"}[kind], dict[str, str]()
    for mark in MARKS:
        if mark in a and mark in b:
            made[mark] = f"{a[mark]} {sign} {b[mark]}"
        elif mark in a or mark in b:
            made[mark] = a[mark] if mark in a else b[mark] if sign == "+" else f"-{b[mark]}"
    return made


def multiplied(a: Mapping[str, str], b: Mapping[str, str], marks: tuple[str, ...]) -> Parts:
    """x y by the product rule."""
    made = {}
    for mark in marks:
        pairs = {"": [("", "")], "a": [("", "a"), ("a", "")], "b": [("", "b"), ("b", "")],
                 "m": [("", "m"), ("a", "b"), ("b", "a"), ("m", "")]}[mark]  # fmt: skip
        terms = [f"{a[x]} * {b[y]}" for x, y in pairs if x in a and y in b]
        if terms:
            made[mark] = f"({' + '.join(terms)}) % {PRIME}" if len(terms) > 1 else f"{terms[0]} % {PRIME}"
    return made


def chained(line: Callable[[str], None], marks: tuple[str, ...], x: Parts, value: str, slope: str, bend: str) -> Parts:
    """f(x) from f, f' and f'' there; `line` writes a statement ahead."""
    made = {"": value}
    if len(x) > 1:
        line(f"d = {slope}")
    for mark in "ab":
        if mark in x:
            made[mark] = f"d * {x[mark]} % {PRIME}"
    mixed = [f"d * {x['m']}"] if "m" in x else []
    if "m" in marks and "a" in x and "b" in x:
        mixed.append(f"({bend}) * {x['a']} % {PRIME} * {x['b']}")
    if mixed:
        made["m"] = f"({' + '.join(mixed)}) % {PRIME}"
    # A slope's variable serves the next operation too: what needs it is evaluated first.
    return made
