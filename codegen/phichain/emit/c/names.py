"""How a scene's C is spelt: its prefix, its type of numbers, its literals, its tables."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from phichain.emit.expressions import Text, double_literal, float_literal


@dataclass(frozen=True)
class CNames:
    """How a scene's C is spelt.

    Attributes:
        prefix: the scene's name, before everything at file scope.
        real: "double" or "float".
        is_plain: whether nothing is written for a host's vectors.
        tables: file-scope name of each table, by (name, values).
    """

    prefix: str
    real: str
    tables: dict[tuple[str, tuple[Fraction, ...]], str]
    is_plain: bool = False

    @property
    def type(self) -> str:
        """The scene's type of numbers, as NAME.h defines it."""
        return f"{self.prefix}_real"

    @property
    def value(self) -> str:
        """How a number that does not change is declared: where no host's vectors are written for, kept in a register (`value.c.j2`)."""
        return f"{self.prefix.upper()}_VALUE" if self.is_plain else f"const {self.type}"

    def number(self, value: Fraction) -> Text:
        """A numeric literal of the scene's type."""
        return float_literal(value) if self.real == "float" else double_literal(value)

    def libm(self, name: str) -> str:
        """The C library's function for the scene's type."""
        return f"{name}f" if self.real == "float" else name
