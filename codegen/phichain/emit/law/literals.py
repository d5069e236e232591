"""Numbers of laws as C and JSON write them."""

from __future__ import annotations

import re
from math import isfinite


def literal(value: float, real: str) -> str:
    """A hexadecimal constant: the number itself, whatever reads it."""
    text = re.sub(r"\.?0*p", "p", value.hex()) if value else "0.0"
    return f"{text}F" if real == "float" else text


def bound(value: float) -> float | None:
    """A limit as JSON has it; none where it is infinite."""
    return value if isfinite(value) else None
