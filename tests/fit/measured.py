"""Chains that are measured: made by the flow from known parameters, with noise of a known size."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from phichain.app.commands.fit import followed
from phichain.motion import simulate
from phichain.pipeline import build
from phichain.scene import Scene
from phichain.system import System

DOUBLE = Scene(
    "measured_double", 2, mass="runtime", length=[0.3, 0.25], com="runtime", inertia="runtime", damping="runtime"
)
PUSHED = Scene(
    "measured_cart", 1, base="cart", cart_mass="runtime", cart_damping="runtime", mass="runtime", length=0.4, actuated="cart"
)
STICKING = Scene("measured_friction", 1, mass=0.3, length=0.4, damping="runtime", friction="runtime", friction_speed=0.3)

TRUTH: Mapping[str, Any] = {"mass": [0.3, 0.2], "com": [0.15, 0.12], "inertia": [0.003, 0.001], "damping": [0.002, 0.001]}
START: Mapping[str, Any] = {"mass": [0.3, 0.2], "com": [0.15, 0.1], "inertia": [0.004, 0.0014], "damping": [0.003, 0.0006]}
KNOWN = ("mass_1", "mass_2", "com_1")
"""Weighed masses and one centre of mass: without inputs, three of the eight numbers cannot be told."""
TOLD: Mapping[str, float] = {"com_2": 0.12, "inertia_1": 0.003, "inertia_2": 0.001, "damping_1": 0.002, "damping_2": 0.001}


@dataclass(frozen=True)
class Made:
    """Columns of a motion without noise."""

    t: np.ndarray
    columns: Mapping[str, np.ndarray]

    def noisy(self, share: float, seed: int) -> dict[str, np.ndarray]:
        """The same with noise of that share of the spread of each column."""
        rng = np.random.default_rng(seed)
        noise = {name: share * np.std(column) * rng.standard_normal(len(self.t)) for name, column in self.columns.items()}
        return {"t": self.t, **{name: column + noise[name] for name, column in self.columns.items()}}


@cache
def system(scene: Scene) -> System:
    return build(followed(scene), prove=False)


def motion(scene: Scene, p: Mapping[str, Any], x0: list[float], t: np.ndarray, u: Any = None) -> Made:
    chain = system(scene)
    x = simulate(chain, x0, t, tol=1e-13, p={k: np.array(v) if isinstance(v, list) else v for k, v in p.items()}, u=u, error_estimate=False).x
    return Made(t, {name: x[:, k] for k, name in enumerate(chain.q_names)})


@cache
def swung() -> Made:
    """The double pendulum, 10 s at 500 Hz."""
    return motion(DOUBLE, TRUTH, [1.5, 0.5, 0.0, 0.0], np.linspace(0, 10, 5001))


@cache
def swung_briefly() -> Made:
    """The double pendulum, 3 s at 100 Hz, from another start."""
    return motion(DOUBLE, TRUTH, [1.2, -0.4, 0.3, 0.0], np.linspace(0, 3, 301))
