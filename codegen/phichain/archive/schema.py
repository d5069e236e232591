"""What a file may hold, of which type and of which shape: arrays and small fields of each kind of record.

Shapes are written in named sizes, ``real("m", "nq")``: the first entry that has a size sets it, and all others must agree; a
size that is a sum, ``"nq+nv"``, follows from its parts.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from sys import float_info
from typing import Any, Final

import numpy as np

META: Final = "meta_json"
LARGEST: Final = 2**32
"""Bytes that a record may take, in its file and in memory."""


@dataclass(frozen=True)
class Array:
    """What an array of a record must be.

    Attributes:
        dtype: Its type; a file may hold another one of the same kind.
        shape: Named sizes.
        is_optional: Whether a record may be without it.
        further: Named size of a last axis that it may have besides; empty for none.
    """

    dtype: type[np.generic]
    shape: tuple[str, ...]
    is_optional: bool = False
    further: str = ""


def real(*shape: str, optional: bool = False, further: str = "") -> Array:
    """An array of real numbers."""
    return Array(np.float64, shape, optional, further)


def whole(*shape: str) -> Array:
    """An array of whole numbers."""
    return Array(np.int64, shape)


def complex_numbers(*shape: str, optional: bool = False) -> Array:
    """An array of complex numbers."""
    return Array(np.complex128, shape, optional)


@dataclass(frozen=True)
class Field:
    """What a small field of a record must be.

    Attributes:
        what: In words.
        fits: Whether a value, as JSON gives it, is one.
        size: Named size of a list.
        is_counted: Whether a list that is empty says that the size is 0; else it says nothing.
        default: What it is in files from before it was kept; None if every file has it.
    """

    what: str
    fits: Callable[[Any], bool]
    size: str = ""
    is_counted: bool = False
    default: Any = None


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _is_count(value: Any) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and 0 <= value < 2**63


def _all(fits: Callable[[Any], bool]) -> Callable[[Any], bool]:
    return lambda value: isinstance(value, list) and all(map(fits, value))


def _is_text(value: Any) -> bool:
    return isinstance(value, str)


TEXT: Final = Field("a text", _is_text)
NUMBER: Final = Field("a number", _is_number)
DURATION: Final = Field("a finite number from 0", lambda value: _is_number(value) and 0 <= value <= float_info.max)
COUNT: Final = Field("a whole number from 0", _is_count)
TRUTH: Final = Field("true or false", lambda value: isinstance(value, bool))
COUNTS: Final = Field("whole numbers by name", lambda value: isinstance(value, dict) and all(map(_is_count, value.values())))


def _are_values(value: Any) -> bool:
    return isinstance(value, dict) and all(_is_number(entry) or _all(_is_number)(entry) for entry in value.values())


VALUES: Final = Field("numbers by name, one or a list of them", _are_values, default={})
"""Runtime parameters; files from before they were kept hold none."""


def names(size: str, counted: bool = False) -> Field:
    """A list of names, as many as a size says; none at all where they are not counted."""
    return Field("a list of names", _all(_is_text), size, counted)


def signs(size: str) -> Field:
    """A list of +1 and -1."""
    return Field("a list of +1 and -1", _all(lambda value: _is_number(value) and value in (1, -1)), size)


def word(*choices: str) -> Field:
    """One of some words."""
    return Field(f"one of {', '.join(choices)}", lambda value: isinstance(value, str) and value in choices)


@dataclass(frozen=True)
class Schema:
    """What a file of one kind of record holds.

    Attributes:
        kind: The kind, the entry `kind` of the small fields.
        arrays: Its arrays by name.
        fields: Its small fields by name.
        filled: The sizes that are not 0.
    """

    kind: str
    arrays: Mapping[str, Array]
    fields: Mapping[str, Field]
    filled: tuple[str, ...] = ()
