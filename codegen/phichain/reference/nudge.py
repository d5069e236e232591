"""Small relative changes of every number of an evaluation, by which the reference measures a problem's own amplification."""

from __future__ import annotations

import random
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

from mpmath import mpf

#: Angles and unit vectors move by the size times 1 at least: their sums, sines and cosines are rounded there by any function.
_OF_ORDER_ONE: Final = ("q", "amplitude")

#: Far below round-off and far above what fifty digits leave over: what moves is the derivative.
SIZE_BITS: Final = 80


@dataclass(frozen=True)
class Nudge:
    """x -> x (1 +- 2^-80), angles and unit vectors by 2^-80 at least; the signs drawn anew for every name and entry, the same in every call.

    Attributes:
        seed: what the signs are drawn from.
    """

    seed: str

    def __call__(self, name: str, entries: Sequence[Any]) -> list[Any]:
        """The entries of one array, moved."""
        source = random.Random(f"{self.seed} {name}")
        size = mpf(2) ** -SIZE_BITS
        least = 1 if name in _OF_ORDER_ONE else 0
        return [mpf(x) + source.choice((-size, size)) * max(least, abs(x)) for x in entries]
