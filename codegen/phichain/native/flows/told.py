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
_FIRST: Final = _HEAD + WATCHED
"""Numbers of a row before its orbit."""
_NAMED: Final = 4
"""Numbers of an event before its place."""


class Found:
    """What is told of an orbit: numbers at once, arrays by name when they are asked for."""

    __slots__ = ("_fields", "_row", "numbers")

    def __init__(self, row: Array, fields: Fields) -> None:
        """Take what C told."""
        row.flags.writeable = False
        self._row, self._fields, self.numbers = row, fields, Numbers._make(row[:_NUMBERS].tolist())

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


class Reached:
    """The orbits of a run, or those on the way to a zero, one after the other: what C told in some rows, taken apart all at once."""

    __slots__ = ("_fields", "_rows", "_tests")

    def __init__(self, rows: Array, fields: Fields, tests: int) -> None:
        """Take the rows, with so many test functions."""
        rows.flags.writeable = False
        self._rows, self._fields, self._tests = rows, fields, tests

    def __len__(self) -> int:
        return len(self._rows)

    def __getitem__(self, some: slice) -> Reached:
        """Some of them, in order."""
        return Reached(self._rows[some], self._fields, self._tests)

    def found(self, place: int) -> Found:
        """What is told of one of them."""
        return Found(self._rows[place, _FIRST:], self._fields)

    def number(self, name: str) -> Array:
        """A number of each (m,)."""
        return self._rows[:, _FIRST + Numbers._fields.index(name)]

    @property
    def arclengths(self) -> Array:
        """Where each is (m,)."""
        return self._rows[:, 0]

    @property
    def heads(self) -> list[list[float]]:
        """Of each: where it is, the step to try behind it, and the test functions there."""
        heads: list[list[float]] = self._rows[:, : _HEAD + self._tests].tolist()
        return heads

    def array(self, name: str) -> Array:
        """An array of each (m, ...)."""
        begin, end, shape = self._fields[name]
        return self._rows[:, _FIRST + begin : _FIRST + end].reshape(-1, *shape)


class Event(NamedTuple):
    """A zero of a test function that a run met: before which of its orbits, which function, arclength, what is left of it, y, and d^T a across the force."""

    before: int
    which: int
    arclength: float
    left: float
    y: Array
    folded: Array

    @classmethod
    def of(cls, row: Array, fields: Fields) -> Event:
        """What C told in a row."""
        before, which, arclength, left = row[:_NAMED].tolist()
        row.flags.writeable = False
        y, folded = (row[slice(*fields[name][:2])] for name in ("y", "folded"))
        return cls(int(before), int(which), arclength, left, y, folded)


class Run(NamedTuple):
    """A run.

    Attributes:
        rows: The orbits.
        events: The zeros before them that it passes.
        stopped: Why there are no more (`desk.STOPPED`), or "interrupted".
        tried: The step that was tried last.
        is_doubtful: Whether more zeros than signs show may lie before the last orbit but one.
    """

    rows: Reached
    events: list[Event]
    stopped: str
    tried: float
    is_doubtful: bool


class Zero(NamedTuple):
    """Where a test function vanishes.

    Attributes:
        rows: The orbits that were computed on the way, with its values alone; steps are above 0 where Newton got there.
        at: Which one is nearest to the zero.
        other: Which one is nearest to that; -2 is the first end of the curve, -1 its last.
        place: Arclength of the zero.
    """

    rows: Reached
    at: int
    other: int
    place: float
