"""The motions that the flows are timed on, and where they end."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.chains import Chain, planar_chain, scene_table, spatial_chain

Array = NDArray[np.float64]
FILE = Path(__file__).with_name("references.json")
BATCH = 8
SPREAD = 1e-3
"""Of the eight starts about theta = (0.4, 0, ...), rad: a user's ensemble. The first one is the single trajectory."""


@dataclass(frozen=True)
class Motion:
    """A chain and its span.

    Attributes:
        name: Its key in references.json and its name in the tables.
        chain: Unforced.
        span: s.
        forms: heyoka's formulations, best guesses of an expert.
    """

    name: str
    chain: Chain
    span: float
    forms: tuple[str, ...]

    def starts(self, count: int = BATCH) -> tuple[Array, Array]:
        """(q, v), one row per trajectory, at rest but for the spatial ones."""
        chain, rng = self.chain, np.random.default_rng(20261122)
        if chain.space == "planar":
            q = np.zeros((count, chain.nq))
            q[:, 0] = 0.4
            return q + SPREAD * rng.standard_normal(q.shape), np.zeros_like(q)
        lean = np.array([[0.4 + 0.2 * k, 0.3 - 0.2 * k, 1.0] for k in range(chain.links)])
        links = lean + SPREAD * rng.standard_normal((count, *lean.shape))
        links /= np.linalg.norm(links, axis=2, keepdims=True)
        rates = rng.standard_normal(links.shape)
        rates -= np.sum(rates * links, axis=2, keepdims=True) * links
        cart = np.zeros((count, 2))
        return np.hstack([cart, links.reshape(count, -1)]), np.hstack([cart, rates.reshape(count, -1)])

    def scene(self, want: Sequence[str], **more: Any) -> Any:
        """The chain as a Scene; `more` are further tables."""
        from phichain.scene import scene_from_dict

        return scene_from_dict({**scene_table(self.chain, tuple(want)), **more})


def motions() -> list[Motion]:
    """All of them; the first is the cheapest to try."""
    planar = {2: 100.0, 1: 100.0, 3: 50.0, 5: 20.0, 8: 10.0}
    spatial = {3: 5.0, 5: 2.0}
    small = ("closed form", "link frame")
    return [
        Motion(f"planar N = {n}", planar_chain(n, forced=False), span, small if 1 < n <= 3 else ("link frame",))
        for n, span in planar.items()
    ] + [
        Motion(f"spatial n = {n}", spatial_chain(n, forced=False), span, ("unit vectors", "tension"))
        for n, span in spatial.items()
    ]


def motion(name: str) -> Motion:
    """By its name."""
    return next(m for m in motions() if m.name == name)


@cache
def references() -> dict[str, Array]:
    """Configurations (BATCH, nq) at the ends, by the motions' names; rounded from extended precision."""
    stored = json.loads(FILE.read_text())
    return {name: np.array([[float(x) for x in row] for row in rows]) for name, rows in stored["ends"].items()}


def error(name: str, found: Array) -> float:
    """The largest difference of an entry of q (rad, m, or of a unit vector) at the end, over the rows given."""
    rows = np.atleast_2d(found)
    return float(np.max(np.abs(rows - references()[name][: len(rows)])))
