"""The numbers of a data sheet, checked: real, finite, and of the sign that their quantity has."""

from __future__ import annotations

from math import isfinite
from numbers import Real

from phichain.errors import SceneError


def number(field: str, value: object, unit: str) -> float:
    """Return a real number as a float.

    Raises:
        SceneError: It is no finite real number.
    """
    if isinstance(value, bool) or not isinstance(value, Real):
        raise SceneError(field, value, "is not a number", f"give a number, {unit}")
    try:
        plain = float(value)
    except OverflowError:
        plain = float("inf")
    if not isfinite(plain):
        raise SceneError(field, value, "is not finite", f"give a finite number, {unit}")
    return plain


def positive(field: str, value: object, unit: str) -> float:
    """Return a number above zero.

    Raises:
        SceneError: It is none.
    """
    plain = number(field, value, unit)
    if plain <= 0:
        raise SceneError(field, value, "is not positive", f"give a number above zero, {unit}")
    return plain


def not_negative(field: str, value: object, unit: str) -> float:
    """Return zero or a number above it.

    Raises:
        SceneError: It is neither.
    """
    plain = number(field, value, unit)
    if plain < 0:
        raise SceneError(field, value, "is negative", f"give zero or a number above it, {unit}")
    return plain


def efficiency(field: str, value: object) -> float:
    """Return a number above zero and at most one.

    Raises:
        SceneError: It is none.
    """
    plain = positive(field, value, "as a part of one")
    if plain > 1:
        raise SceneError(field, value, "is above one", "give a part of one, such as 0.9 for 90 %")
    return plain
