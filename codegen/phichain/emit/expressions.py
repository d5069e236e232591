"""Scalars as text: operands, numbers and operator precedence, shared by the backends that print infix expressions."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from phichain.errors import EmissionError

ATOM, PRODUCT, SUM = 3, 2, 1


@dataclass(frozen=True, slots=True)
class Text:
    """An expression and how tightly its outermost operator binds."""

    text: str
    binding: int = ATOM

    def within(self, binding: int) -> str:
        """The expression as part of one that binds this tightly."""
        return self.text if self.binding >= binding else f"({self.text})"


def infix(kind: str, args: list[Text]) -> Text | None:
    """Arithmetic with the fewest parentheses; None for kinds that are functions."""
    match kind:
        case "add":
            return Text(f"{args[0].within(SUM)} + {args[1].within(PRODUCT)}", SUM)
        case "sub":
            return Text(f"{args[0].within(SUM)} - {args[1].within(PRODUCT)}", SUM)
        case "mul":
            return Text(f"{args[0].within(PRODUCT)} * {args[1].within(ATOM)}", PRODUCT)
        case "div":
            return Text(f"{args[0].within(PRODUCT)} / {args[1].within(ATOM)}", PRODUCT)
        case "neg":
            return Text(f"-{args[0].within(ATOM)}", SUM)
    return None


def double_literal(value: Fraction) -> Text:
    """The nearest double in its shortest decimal form."""
    number = _nearest(value, float(value), "double")
    text = repr(number)
    if "e" in text and "." not in text:
        text = text.replace("e", ".0e")
    return Text(text, SUM if number < 0 else ATOM)


def float_literal(value: Fraction) -> Text:
    """The nearest single-precision number in its shortest decimal form, with the suffix C wants."""
    number = np.float32(_nearest(value, float(value), "float"))
    _nearest(value, float(number), "float")
    text = np.format_float_scientific(number, unique=True, trim="0", exp_digits=1)
    plain = np.format_float_positional(number, unique=True, trim="0")
    shorter = plain if len(plain) <= len(text) + 2 else text
    return Text(f"{shorter}f", SUM if number < 0 else ATOM)


def _nearest(value: Fraction, number: float, real: str) -> float:
    """The number, unless rounding has lost it altogether."""
    if np.isinf(number) or (number == 0.0 and value):
        raise EmissionError(
            "constant", float(value), f"a constant of the scene does not fit into {real}",
            "rescale the scene's units or set target.real = \"double\"",
        )  # fmt: skip
    return number
