"""The canonical digest of a scene's tables."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from typing import Any


def digest_of(tables: Mapping[str, Any]) -> str:
    """Return the SHA-256 (hex) of nested tables as canonical JSON.

    Keys are sorted and floats written in hexadecimal, which has one spelling per number, so the digest
    depends on what the tables say and on nothing else.
    """
    text = json.dumps(_canonical(tables), sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(text.encode("ascii")).hexdigest()


def _canonical(value: object) -> object:
    """Return nested tables with every float in hexadecimal."""
    if isinstance(value, Mapping):
        return {key: _canonical(entry) for key, entry in value.items()}
    if isinstance(value, list):
        return [_canonical(entry) for entry in value]
    return value.hex() if isinstance(value, float) else value
