"""What is told of brake orbits by the compiled object: records of the numbers on its desk, whose fields `desk` says."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final, NamedTuple

from phichain.native.flows.desk import WATCHED, Array, Numbers, Shape

Fields = Mapping[str, tuple[int, int, Shape]]
"""Where every field of an orbit begins and ends, and its shape (`desk.offsets`)."""
_NUMBERS: Final = len(Numbers._fields)
_HEAD: Final = 2
"""Numbers of a row before its test functions."""


class Found:
    """What is told of an orbit: numbers at once, arrays by name when they are asked for."""

    __slots__ = ("_fields", "_row", "numbers")

    def __init__(self, row: Array, fields: Fields) -> None:
        """Take what C told."""
        row.flags.writeable = False
        self._row, self._fields, self.numbers = row, fields, Numbers(*row[:_NUMBERS].tolist())

    def array(self, name: str) -> Array:
        """An array."""
        begin, end, shape = self._fields[name]
        part = self._row[begin:end]
        return part if len(shape) == 1 else part.reshape(shape)


class Ahead(NamedTuple):
    """How a step went: how far it led, how far Newton moved its guess, the cosine of its turn, and the size of [J; t]^-1 dJ."""

    moved: float
    shifted: float
    turned: float
    changed: float


class Reached(NamedTuple):
    """An orbit of a run: what is told of it, where it is, the step to try behind it, and the test functions there."""

    found: Found
    arclength: float
    step: float
    values: tuple[float, ...]

    @classmethod
    def of(cls, row: Array, fields: Fields, tests: int) -> Reached:
        """What C told in a row, with so many test functions."""
        arclength, step, *values = row[: _HEAD + tests].tolist()
        return cls(Found(row[_HEAD + WATCHED :], fields), arclength, step, tuple(values))


class Zero(NamedTuple):
    """Where a test function vanishes.

    Attributes:
        rows: The orbits that were computed on the way, with its values alone; steps are above 0 where Newton got there.
        at: Which one is nearest to the zero.
        other: Which one is nearest to that; -2 is the first end of the curve, -1 its last.
        place: Arclength of the zero.
    """

    rows: list[Reached]
    at: int
    other: int
    place: float
