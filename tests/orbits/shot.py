"""Chains whose flow carries derivatives along, compiled once a session."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

from phichain.pipeline import build
from phichain.scene import Scene
from phichain.system import System

WANT = ("propagate", "mass_matrix", "energy", "forward_dynamics", "phi", "phi_jacobian")


@lru_cache
def uniform(links: int, **more: Any) -> System:
    """Paper A's chain of N links without torques, m = l = 1/N, com = l/2."""
    own = {"mass": 1 / links, "length": 1 / links, "com": 0.5 / links, "actuated": "none", "want": WANT, "variational": True}
    name = "_".join([f"shot{links}", *more]) if more else f"shot{links}"
    return build(Scene(name, links, **{**own, **more}))
