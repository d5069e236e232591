"""Ten chaotic motions of 60 s, and where they are every two seconds."""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
FILE = Path(__file__).with_name("references.json")
TIMES = np.linspace(0.0, 60.0, 31)
WANT = ("forward_dynamics", "energy", "state_jacobian", "propagate", "propagate_stiff", "step")


@dataclass(frozen=True)
class Case:
    """A chain and its start.

    Attributes:
        name: Its key in references.json, and its scene's name.
        table: Its scene, but for the functions.
        q: Configuration at the start; at rest unless `v` says otherwise.
        v: Rates.
    """

    name: str
    table: dict[str, Any]
    q: tuple[float, ...]
    v: tuple[float, ...] = ()

    @property
    def x0(self) -> Array:
        """The state at the start."""
        return np.array([*self.q, *(self.v or (0.0,) * len(self.q))])

    def scene(self, want: tuple[str, ...] = WANT) -> Any:
        """The chain as a Scene."""
        from phichain.scene import scene_from_dict

        return scene_from_dict({"name": self.name, **self.table, "functions": {"want": list(want)}})


def _planar(name: str, q: tuple[float, ...], v: tuple[float, ...] = (), angles: str = "relative", **chain: Any) -> Case:
    table = {"chain": {"links": len(q), "mass": 1.0, "length": 1.0, **chain}, "joints": {"angles": angles}}
    return Case(name, table, q, v)


_CART = {"links": 2, "mass": [1.0, 0.5], "length": [1.0, 0.6], "base": "cart", "cart_mass": 2.0}
CASES = (
    _planar("wild_pair", tuple(np.deg2rad([120.0, -10.0]).tolist()), angles="absolute", gravity=9.8),
    _planar("rod_pair", (2.0, 0.0), com=0.5),
    _planar("light_pair", (1.6, 0.5), (0.0, 1.0), mass=[1.0, 0.2], length=[0.7, 0.4]),
    _planar("heavy_pair", (1.2, 1.2), mass=[0.5, 2.0], length=[1.0, 1.5]),
    _planar("long_pair", (2.6, -1.0), length=[3.0, 2.0]),
    Case("cart_pair", {"chain": _CART, "joints": {"angles": "absolute"}}, (0.0, 2.2, 1.0)),
    _planar("triple", (1.9, -0.4, 0.8)),
    _planar("slow_triple", (1.7, 0.0, 0.9), length=2.0, gravity=1.62),
    _planar("long_triple", (1.8, -0.6, 0.5), length=[2.0, 3.0, 1.0], com=[1.5, 1.5, 0.8]),
    _planar("uneven_triple", (2.2, 1.5, 1.2), angles="absolute", mass=[1.0, 0.5, 0.25], length=[1.0, 1.2, 0.8]),
)


@cache
def references() -> dict[str, tuple[float, Array]]:
    """Until when a reference holds, s, and its states (31, nx), by name."""
    kept = json.loads(FILE.read_text())["motions"]
    return {name: (entry["until"], np.array(entry["states"], dtype=float)) for name, entry in kept.items()}
