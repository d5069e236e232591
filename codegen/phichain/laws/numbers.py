"""Numbers of frozen laws: nested tuples of a given shape, deviations less whole turns, and what files hold of them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from phichain.archive import Schema, read_archive
from phichain.errors import ArrayError, OutputError

Row = tuple[float, ...]
Matrix = tuple[Row, ...]
Vector = NDArray[np.float64]
Law = TypeVar("Law")


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


def less_turns(away: Vector, wraps: Sequence[bool]) -> Vector:
    """Deviations (..., n) less whole turns, where they are angles: in [-pi, pi)."""
    turn = 2 * np.pi
    return np.where(wraps, away - turn * np.floor(away / turn + 0.5), away)


def words_of(meta: Mapping[str, Any], words: Iterable[str]) -> dict[str, Any]:
    """Small fields of a file as a law holds them: lists as tuples."""
    return {name: tuple(meta[name]) if isinstance(meta[name], list) else meta[name] for name in words}


def read_law(path: Path | str, schema: Schema, made: Callable[[dict[str, Any], dict[str, Any]], Law]) -> Law:
    """A law from its file.

    Args:
        path: The file.
        schema: What it holds.
        made: From its arrays and its small fields, lists as tuples, to the law.

    Raises:
        OutputError: The file is missing, holds no such law, or one that does not fit together.
    """
    arrays, meta = read_archive(path, schema)
    try:
        return made(dict(arrays), words_of(meta, schema.fields))
    except (ArrayError, KeyError, TypeError) as failure:
        remedy = f"name a file that a {schema.kind} wrote"
        raise OutputError("path", str(path), f"no {schema.kind} can be read there: {failure}", remedy) from failure


def _tuples(values: Sequence[Any]) -> tuple[Any, ...]:
    return tuple(_tuples(entry) if isinstance(entry, list) else entry for entry in values)
