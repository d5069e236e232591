"""Where a result comes from, said in one place for every file that holds one: the version, the chain, its parameters, how it was found."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from typing import Any, Final

import numpy as np

from phichain._version import __version__

WROTE: Final = "phichain"
"""Small field of every file: the version that wrote it."""


def origin(record: object) -> dict[str, Any]:
    """Where a record comes from: the version, its kind, and those of its fields that are texts, numbers or tables of them.

    So it tells the scene and its digest, the runtime parameters `p`, method, tolerance and mode, as far as a record of its kind has them.
    """
    known = fields(record) if is_dataclass(record) else ()
    said = {field.name: plain(value) for field in known if _is_small(value := getattr(record, field.name))}
    return {WROTE: __version__, "record": type(record).__name__, **{name: value for name, value in said.items() if value not in ("", {}, None)}}


def _is_small(value: object) -> bool:
    """Texts, numbers and tables of them, but no tables of whole signals."""
    if isinstance(value, Mapping):
        return not any(isinstance(entry, np.ndarray) and entry.ndim > 1 for entry in value.values())
    return isinstance(value, str | int | float)


def plain(value: Any) -> Any:
    """A value as JSON and YAML have it: numbers that are none become null, complex ones pairs, arrays lists, records tables."""
    if isinstance(value, Mapping):
        return {str(key): plain(entry) for key, entry in value.items()}
    if is_dataclass(value) and not isinstance(value, type):
        return plain({field.name: getattr(value, field.name) for field in fields(value)})
    if isinstance(value, list | tuple):
        return [plain(entry) for entry in value]
    if isinstance(value, np.ndarray | np.generic):
        return plain(value.tolist())
    if isinstance(value, complex):
        return [value.real, value.imag]
    return None if isinstance(value, float) and not math.isfinite(value) else value
