"""Words that a user may have meant."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import SequenceMatcher


def nearest(name: str, valid: Iterable[str]) -> str:
    """Return the valid name most similar to `name`; of equally similar ones the first."""
    return max(valid, key=lambda candidate: SequenceMatcher(None, name.lower(), candidate).ratio())
