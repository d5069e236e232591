"""How a scene's C is spelt: its prefix, its type of numbers, its literals, its tables."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Final

from phichain.emit.expressions import Text, double_literal, float_literal

#: What an array of pairs is called.
SIDE_BY_SIDE: Final = "sine_cosine"


@dataclass(frozen=True)
class CNames:
    """How a scene's C is spelt.

    Attributes:
        prefix: the scene's name, before everything at file scope.
        real: "double" or "float".
        is_plain: whether nothing is written for a host's vectors.
        has_pairs: whether the kernel of the file sets sines and cosines side by side.
        tables: file-scope name of each table, by (name, values).
    """

    prefix: str
    real: str
    tables: dict[tuple[str, tuple[Fraction, ...]], str]
    is_plain: bool = False
    has_pairs: bool = False

    @property
    def type(self) -> str:
        """The scene's type of numbers, as NAME.h defines it."""
        return f"{self.prefix}_real"

    @property
    def value(self) -> str:
        """How a number that does not change is declared: where no host's vectors are written for, kept in a register (`value.c.j2`)."""
        return f"{self.prefix.upper()}_VALUE" if self.is_plain else f"const {self.type}"

    @property
    def register(self) -> str:
        """What stands before the declaration of what changes, where no host's vectors are written for: kept in a register as well."""
        return f"{self.prefix.upper()}_REGISTER " if self.is_plain else ""

    def number(self, value: Fraction) -> Text:
        """A numeric literal of the scene's type."""
        return float_literal(value) if self.real == "float" else double_literal(value)

    def negated_last(self, product: Text) -> Text:
        """-2 x as -(2 x), where nothing is written for a host's vectors: one instruction of Cortex-M4F, and one constant less."""
        positive = product.opposite
        return product if positive is None or not self.is_plain else Text(f"-({positive.text})", product.binding, positive)

    def libm(self, name: str) -> str:
        """The C library's function for the scene's type."""
        return f"{name}f" if self.real == "float" else name
