"""References of the extreme cases, and the norm in which everything is measured against them."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import mpmath as mp

FILE = Path(__file__).with_name("references.json")
_DIGITS = 40

Row = Sequence[Any]


@dataclass(frozen=True)
class Reference:
    """What is known about one case.

    Attributes:
        rows: (q, v) per time, or accelerations, or the frequency.
        kappa: condition number per row.
        fastest: the fastest rate of the motion, in which errors of rates are measured.
    """

    rows: tuple[tuple[mp.mpf, ...], ...]
    kappa: tuple[float, ...]
    fastest: float


def read() -> dict[str, dict[str, Any]]:
    """The file as it is; empty when there is none."""
    content: dict[str, dict[str, Any]] = json.loads(FILE.read_text()) if FILE.exists() else {}
    return content


@cache
def references() -> dict[str, Reference]:
    """By the cases' names."""
    with mp.workdps(_DIGITS):
        return {
            name: Reference(
                tuple(tuple(mp.mpf(x) for x in row) for row in entry["rows"]),
                tuple(entry["kappa"]),
                entry["fastest"],
            )
            for name, entry in read().items()
        }


def gap(exact: Sequence[Row], found: Sequence[Row], fastest: float) -> float:
    """The worst over the rows: positions over max(1, max |q|), rates over the fastest rate of the motion."""
    with mp.workdps(_DIGITS):
        return max(float(_state_gap(a, b, fastest)) for a, b in zip(exact, found, strict=True))


def _state_gap(exact: Row, found: Row, fastest: float) -> mp.mpf:
    half = len(exact) // 2
    worst = [
        max(abs(mp.mpf(a) - mp.mpf(b)) for a, b in zip(exact[part], found[part], strict=True))
        for part in (slice(half), slice(half, None))
    ]
    reach = max(1, *(abs(mp.mpf(a)) for a in exact[:half]))
    speed = max(mp.mpf(fastest), *(abs(mp.mpf(a)) for a in exact[half:]))
    return max(worst[0] / reach, worst[1] / speed if speed else worst[1])


def relative_gap(exact: Row, found: Row) -> float:
    """Largest difference over largest entry."""
    with mp.workdps(_DIGITS):
        worst = max(abs(mp.mpf(a) - mp.mpf(b)) for a, b in zip(exact, found, strict=True))
        return float(worst / max(abs(mp.mpf(a)) for a in exact))
