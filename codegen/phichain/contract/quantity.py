"""The records of the table of named quantities."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Quantity:
    """One row.

    Attributes:
        name: the name in the Program, without the numbers and loop variables behind it.
        unit: its unit; empty for a pure number.
        meaning: one line.
    """

    name: str
    unit: str
    meaning: str


@dataclass(frozen=True)
class Quantities:
    """Names that mean the same in some functions.

    Attributes:
        functions: whose names these are.
        source: where docs/theory.md derives them.
        rows: the names.
        space: "planar" or "spatial" where the other kind of chain means something else by them.
    """

    functions: frozenset[str]
    source: str
    rows: tuple[Quantity, ...]
    space: str = ""


def rows(*rows: tuple[str, str, str]) -> tuple[Quantity, ...]:
    """Rows of which one may name several, separated by blanks, that mean the same in turn."""
    return tuple(Quantity(name, unit, meaning) for names, unit, meaning in rows for name in names.split())
