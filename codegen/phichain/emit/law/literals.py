"""Numbers of laws as C and JSON write them, and what the headers of laws with a state have in common."""

from __future__ import annotations

import re
from math import isfinite
from typing import Final

BYTES: Final = {"double": 8, "float": 4}
"""Bytes of a number of each type."""


def literal(value: float, real: str) -> str:
    """A hexadecimal constant: the number itself, whatever reads it."""
    text = re.sub(r"\.?0*p", "p", value.hex()) if value else "0.0"
    return f"{text}F" if real == "float" else text


def bound(value: float) -> float | None:
    """A limit as JSON has it; none where it is infinite."""
    return value if isfinite(value) else None


MANNERS = (
    "SI units throughout. The functions keep nothing but what stands in the state, which its caller owns, allocate nothing, and may be "
    "called from several threads at once, each with a state of its own."
)
"""How functions with a state behave."""
