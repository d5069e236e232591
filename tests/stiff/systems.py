"""Systems that the tests of the stiff flow share, each generated and compiled once."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np

from phichain.pipeline import build
from phichain.scene import Scene, scene_from_dict
from phichain.system import System

WANT = ("forward_dynamics", "energy", "state_jacobian", "step_rosenbrock", "propagate_stiff")


def chain(
    name: str, links: int = 2, joints: dict[str, Any] | None = None, real: str = "double", **more: Any
) -> Scene:
    """A chain of equal links of 1 kg and 1 m."""
    table: dict[str, Any] = {"links": links, "mass": 1.0, "length": 1.0, **more}
    record = {"name": name, "chain": table, "functions": {"want": list(WANT)}, "target": {"real": real}}
    return scene_from_dict(record | ({"joints": joints} if joints else {}))


@cache
def system(name: str) -> System:
    """A compiled system by the name of its scene."""
    return build(SCENES[name])


SCENES = {
    scene.name: scene
    for scene in (
        # Case B10 of the extreme cases: a joint near critical damping at 7e6 rad/s.
        chain("rigid_joint", joints={"stiffness": [0.0, 1e13], "damping": [0.0, 3e6]}, gravity=9.81),
        chain("overdamped", joints={"damping": [1e6, 1e6]}),
        chain("free_pair", com=0.5),
        chain("spatial_stiff", space="spatial", base="cart", cart_mass=1.0, mass="runtime", com=[0.5, 0.5],
              joints={"stiffness": [1e4, 1e5], "damping": [1e2, 1e3]}),
        chain("spatial_free", space="spatial"),
        chain("single_precision", joints={"damping": [0.0, 1e3]}, real="float"),
    )
}  # fmt: skip


def spatial_start(links: int, cart: int) -> tuple[np.ndarray, np.ndarray]:
    """Links that hang about, with tangent rates."""
    rng = np.random.default_rng(3)
    q = rng.normal(size=(links, 3)) + [0.0, 0.0, 2.0]
    q /= np.linalg.norm(q, axis=1)[:, None]
    w = rng.normal(size=(links, 3))
    w -= q * np.sum(q * w, axis=1)[:, None]
    return np.append(np.zeros(cart), q), np.append(np.zeros(cart), w)
