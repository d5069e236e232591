"""Numbers from callers, as doubles and whole numbers; whatever is none is one typed error."""

from __future__ import annotations

import math
import operator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phichain.errors import ArrayError, ControlError, PhichainError, ToleranceError

Vector = NDArray[np.float64]

_DOUBLE = np.dtype(np.float64)
_REALS = "biuf"
"""NumPy's letters of the types that doubles hold: truth values, whole numbers, real numbers."""


def reals(field: str, values: object, remedy: str, error: type[PhichainError] = ArrayError) -> Vector:
    """Values as an array of doubles of their own shape; the very array where it is one.

    Raises:
        PhichainError: Of the given kind: they are complex, text, objects, ragged or no numbers.
    """
    if type(values) is np.ndarray and values.dtype is _DOUBLE:
        return values
    try:
        array = np.asarray(values)
        # A list of nothing is an array of doubles, and so is a list of arrays of length 0.
        if array.dtype.kind not in _REALS:
            raise TypeError(array.dtype)
        return np.asarray(array, dtype=float)
    except Exception as failure:  # a caller's object may fail in its own way when it is made an array
        raise error(field, values, "does not hold real numbers", remedy) from failure


def real_numbers(field: str, values: object, remedy: str) -> Vector:
    """`reals` for the regulators.

    Raises:
        ControlError: They are complex, ragged or no numbers.
    """
    return reals(field, values, remedy, ControlError)


def number(field: str, value: object, remedy: str, error: type[PhichainError] = ArrayError) -> float:
    """A finite real number.

    Raises:
        PhichainError: Of the given kind: it is none.
    """
    if type(value) is float and math.isfinite(value):
        return value
    array = reals(field, value, remedy, error)
    if array.ndim or not math.isfinite(array):
        raise error(field, value, "is not a finite number", remedy)
    return float(array)


def positive(field: str, value: object, remedy: str, error: type[PhichainError] = ToleranceError) -> float:
    """A finite number above zero.

    Raises:
        PhichainError: Of the given kind: it is none.
    """
    if type(value) is float and 0 < value < math.inf:
        return value
    array = reals(field, value, remedy, error)
    if array.ndim or not (math.isfinite(array) and array > 0):
        raise error(field, value, "must be positive and finite", remedy)
    return float(array)


def whole(
    field: str, value: Any, least: int, most: int, remedy: str, error: type[PhichainError] = ToleranceError
) -> int:
    """A whole number between two bounds, both included; a float that is whole counts as one.

    Raises:
        PhichainError: Of the given kind: it is none, or lies outside.
    """
    if type(value) is int and least <= value <= most:
        return value
    try:
        result = int(value) if isinstance(value, float | np.floating) and float(value).is_integer() else operator.index(value)
    except (TypeError, ValueError) as failure:
        raise error(field, value, "is not a whole number", remedy) from failure
    if not least <= result <= most:
        raise error(field, value, f"must be at least {least}" if result < least else f"must be at most {most}", remedy)
    return result
