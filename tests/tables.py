"""Tables that records wrote, without the comments above their header."""

from pathlib import Path
from typing import Any

import numpy as np


def lines(path: Path | str) -> list[str]:
    """Header and rows."""
    return [line for line in Path(path).read_text(encoding="utf-8").splitlines() if not line.startswith("#")]


def table(path: Path | str) -> Any:
    """Columns by name."""
    return np.genfromtxt(lines(path), delimiter=",", names=True)
