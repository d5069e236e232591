"""Numbers of frozen laws: nested tuples of a given shape."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from phichain.errors import ArrayError

Row = tuple[float, ...]
Matrix = tuple[Row, ...]


def as_numbers(field: str, values: Any, shape: tuple[int, ...], infinite: bool = False) -> Any:
    """Numbers of a shape as nested tuples.

    Args:
        field: What they are, for messages.
        values: Anything that NumPy takes for an array.
        shape: What they must have.
        infinite: Whether they may be infinite, as limits may.

    Raises:
        ArrayError: Another shape, or numbers that are not finite.
    """
    try:
        given = np.asarray(values, dtype=float)
    except (TypeError, ValueError):
        given = np.full((), np.nan)
    # No row says nothing of how long rows would be.
    if given.shape == (0,) and shape[:1] == (0,):
        given = given.reshape(shape)
    sound = np.isfinite(given) | (np.isinf(given) & infinite)
    if given.shape != shape or not np.all(sound):
        raise ArrayError(field, values, f"must hold finite numbers of shape {shape}", "give one for each")
    return _tuples(given.tolist())


def _tuples(values: Sequence[Any]) -> tuple[Any, ...]:
    return tuple(_tuples(entry) if isinstance(entry, list) else entry for entry in values)
