"""Scalars as text: operands, numbers and operator precedence, shared by the backends that print infix expressions."""

from __future__ import annotations

from dataclasses import dataclass
from decimal import Decimal
from fractions import Fraction
from math import isinf

from phichain.errors import EmissionError
from phichain.ir.rounded import nearest

ATOM, PRODUCT, SUM = 3, 2, 1


@dataclass(frozen=True, slots=True)
class Text:
    """An expression and how tightly its outermost operator binds.

    Attributes:
        text: the expression.
        binding: ATOM, PRODUCT or SUM; what starts with a minus counts as a product.
        opposite: the expression without the minus it starts with, if it starts with one. Rounding is symmetric, so
            ``a + -b * c`` and ``a - b * c`` are the same number to the last bit.
    """

    text: str
    binding: int = ATOM
    opposite: Text | None = None

    def within(self, binding: int) -> str:
        """The expression as part of one that binds this tightly."""
        return self.text if self.binding >= binding else f"({self.text})"


def infix(kind: str, args: list[Text]) -> Text | None:
    """Arithmetic with the fewest parentheses; None for kinds that are functions."""
    match kind:
        case "add" | "sub":
            return _sum(kind == "add", *args)
        case "mul":
            return _product("*", *args)
        case "div":
            return _product("/", *args)
        case "neg":
            return args[0].opposite or _negative(args[0])
    return None


def double_literal(value: Fraction) -> Text:
    """The nearest double in its shortest decimal form."""
    if value < 0:
        return _negative(double_literal(-value))
    text = repr(_checked(value, nearest("double", value), "double"))
    return Text(text.replace("e", ".0e") if "e" in text and "." not in text else text)


def float_literal(value: Fraction) -> Text:
    """The nearest single-precision number in its shortest decimal form, with the suffix C wants."""
    if value < 0:
        return _negative(float_literal(-value))
    return Text(f"{_shortest(_checked(value, nearest('float', value), 'float'))}F")


def _shortest(number: float) -> str:
    """The nearest decimal to a positive single-precision number of the fewest digits that are read back as that number."""
    for places in range(9):
        text = f"{number:.{places}e}"
        if nearest("float", Fraction(text)) == number:
            break
    mantissa, exponent = text.split("e")
    plain = f"{Decimal(text):f}"
    scientific, plain = (x if "." in x else f"{x}.0" for x in (mantissa, plain))
    scientific = f"{scientific}e{int(exponent):+d}"
    return plain if len(plain) <= len(scientific) + 2 else scientific


def _sum(is_plus: bool, first: Text, second: Text) -> Text:
    """``first + second`` or ``first - second``; two signs in a row become one."""
    if second.opposite is not None:
        is_plus, second = not is_plus, second.opposite
    return Text(f"{first.within(SUM)} {'+' if is_plus else '-'} {second.within(PRODUCT)}", SUM)


def _product(operator: str, first: Text, second: Text) -> Text:
    def product(factor: Text) -> str:
        return f"{factor.within(PRODUCT)} {operator} {second.within(ATOM)}"

    opposite = None if first.opposite is None else Text(product(first.opposite), PRODUCT)
    return Text(product(first), PRODUCT, opposite)


def _negative(positive: Text) -> Text:
    return Text(f"-{positive.within(PRODUCT)}", PRODUCT, positive)


def _checked(value: Fraction, number: float, real: str) -> float:
    """The number, unless rounding has lost it altogether."""
    if isinf(number) or (number == 0.0 and value):
        tens = len(str(value.numerator)) - len(str(value.denominator))
        other = " or set target.real = \"double\"" if real == "float" else ""
        raise EmissionError(
            "constant", f"about 1e{tens}", f"a constant of the scene does not fit into {real}",
            f"rescale the scene's units{other}",
        )  # fmt: skip
    return number
