"""Chains whose numbers spread over many decades, and the error that double-precision arguments leave attainable."""

from __future__ import annotations

import random
from dataclasses import dataclass
from typing import Any

import numpy as np
from mpmath import mp, mpf

from phichain.reference import reference
from phichain.scene import Scene
from tests.reference_cases import relative_error

Arguments = dict[str, list[Any]]
_HALF_ULP = mpf(2) ** -53

#: Masses, lengths and places of the masses on their links, for any number of links.
SPREADS: dict[str, Any] = {
    "alike": lambda n: (np.ones(n), np.ones(n)),
    "heavy tip": lambda n: (np.where(np.arange(n) == n - 1, 1e8, 1.0), np.ones(n)),
    "heavy root": lambda n: (np.where(np.arange(n) == 0, 1e8, 1.0), np.ones(n)),
    "heavy in turn": lambda n: (np.where(np.arange(n) % 2, 1e8, 1.0), np.ones(n)),
    "heavier outwards": lambda n: (np.logspace(-8, 8, n), np.ones(n)),
    "lighter and longer outwards": lambda n: (np.logspace(8, -8, n), np.logspace(-4, 4, n)),
    "short in turn": lambda n: (np.ones(n), np.where(np.arange(n) % 2, 1e-8, 1.0)),
    "light with a tip": lambda n: (np.where(np.arange(n) == n - 1, 1.0, 1e-8), np.ones(n)),
}
#: r / l, or None for masses at the ends.
PLACES: dict[str, float | None] = {"at the end": None, "half way": 0.5, "near the joint": 1e-8, "near the end": 1 - 1e-8}


@dataclass(frozen=True)
class Hard:
    """A scene in a state."""

    scene: Scene
    inputs: Arguments

    def truth(self, inputs: Arguments | None = None) -> list[Any]:
        """Accelerations to 30 digits."""
        return reference(self.scene, "forward_dynamics", inputs or self.inputs, digits=30)["a"]

    def attainable(self, trials: int = 4, half_ulp: mpf = _HALF_ULP) -> float:
        """The largest change of the exact accelerations when every argument is off by half a unit in the last place.

        Angles and directions by that of 1 at least: sums of angles, sines and cosines are rounded there.
        """
        rnd, exact, worst = random.Random(1), self.truth(), 0.0
        for _ in range(trials):
            with mp.workdps(60):
                moved = {
                    name: [x + rnd.choice((-1, 1)) * half_ulp * max(abs(x), int(name == "q")) for x in values]
                    for name, values in self.inputs.items()
                }
                worst = max(worst, relative_error(self.truth(moved), exact))
        return worst


def hard_chain(links: int, space: str, spread: str, place: str, **more: Any) -> Hard:
    """A chain in a random state; `straight`, `folded` and `fast` in `more` say what is special about it."""
    shape = next((more.pop(name) and name for name in ("straight", "folded", "fast") if name in more), None)
    rng = np.random.default_rng(7)
    mass, length = SPREADS[spread](links)
    com = None if PLACES[place] is None else (PLACES[place] * length).tolist()
    if space == "planar" and "actuated" not in more and "stiffness" not in more:
        more["actuated"] = "all"
    chain = Scene("hard", links, space=space, mass=mass.tolist(), length=length.tolist(), com=com, **more)
    q, v = _planar_state(chain, rng, shape) if chain.is_planar else _spatial_state(chain, rng, shape)
    inputs = {"q": q.tolist(), "v": v.tolist()}
    if chain.nu:
        inputs["u"] = rng.normal(size=chain.nu).tolist()
    return Hard(chain, inputs)


def _planar_state(chain: Scene, rng: np.random.Generator, shape: str | None) -> tuple[np.ndarray, np.ndarray]:
    q, v = rng.uniform(-np.pi, np.pi, chain.nq), 2 * rng.normal(size=chain.nv)
    first = chain.nq - chain.links
    if shape == "straight":
        q[first + 1 :] = 1e-4 * rng.normal(size=chain.links - 1)
    if shape == "folded":
        q[first + 1 :] = np.pi
    if shape == "fast":
        q, v = rng.uniform(-1e6, 1e6, chain.nq), 1e4 * rng.normal(size=chain.nv)
    return q, v


def _spatial_state(chain: Scene, rng: np.random.Generator, shape: str | None) -> tuple[np.ndarray, np.ndarray]:
    cart = np.zeros(2 * chain.has_cart)
    q = rng.normal(size=(chain.links, 3))
    if shape == "straight":
        q = np.array([0.3, 0.4, 0.866]) + 1e-4 * q
    if shape == "folded":
        q = np.outer((-1.0) ** np.arange(chain.links), [0.3, 0.4, 0.866])
    q /= np.linalg.norm(q, axis=1)[:, None]
    v = (1e4 if shape == "fast" else 2) * rng.normal(size=q.shape)
    v -= q * np.sum(q * v, axis=1)[:, None]
    return np.concatenate([cart, q.ravel()]), np.concatenate([cart, v.ravel()])
