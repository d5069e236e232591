"""Small compiled chains with inputs, built once for the tests of inputs in time."""

from __future__ import annotations

from functools import cache
from typing import Any

from phichain.pipeline import build
from phichain.scene import scene_from_dict
from phichain.system import System

WANT = ["forward_dynamics", "energy", "state_jacobian", "linearization", "propagate", "propagate_stiff", "step"]


@cache
def pendulum() -> System:
    """One link with a torque."""
    return _built("pushed_pendulum", {"links": 1, "mass": 0.8, "length": 0.6}, {"actuated": "all"})


@cache
def pair(angles: str = "relative", damping: float = 0.0) -> System:
    """Two links with two torques."""
    chain = {"links": 2, "mass": [0.5, 0.3], "length": [0.4, 0.5], "com": [0.2, 0.3]}
    damped = {"damping": [damping, 2 * damping]} if damping else {}
    return _built(f"pushed_pair_{angles}_{bool(damping)}", chain, {"angles": angles, "actuated": "all", **damped})


@cache
def cart_pole() -> System:
    """The cart of the sampled law: 1 kg, with 1 kg on 0.5 m."""
    return _built("sampled_cart", {"links": 1, "mass": 1.0, "length": 0.5, "base": "cart", "cart_mass": 1.0}, {})


@cache
def single_cart_pole() -> System:
    """The same in single precision."""
    chain = {"links": 1, "mass": 1.0, "length": 0.5, "base": "cart", "cart_mass": 1.0}
    functions = {"want": ["forward_dynamics", "energy", "propagate", "propagate_stiff"]}
    scene = {"name": "sampled_cart_float", "chain": chain, "functions": functions, "target": {"real": "float"}}
    return build(scene_from_dict(scene), prove=False)


@cache
def globe() -> System:
    """Two damped links in space on a cart."""
    chain = {"links": 2, "space": "spatial", "mass": [0.5, 0.3], "length": [0.4, 0.5], "base": "cart", "cart_mass": 0.7}
    want = ["forward_dynamics", "energy", "propagate"]
    return _built("pushed_globe", chain, {"damping": [0.05, 0.02]}, want)


def _built(name: str, chain: dict[str, Any], joints: dict[str, Any], want: list[str] = WANT) -> System:
    return build(scene_from_dict({"name": name, "chain": chain, "joints": joints, "functions": {"want": want}}), prove=False)
