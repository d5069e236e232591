"""Chains of three links of every kind, with random states, for the tests of the reference."""

from __future__ import annotations

import random
from typing import Any

import pytest
from mpmath import mpf

from phichain.reference import reference
from phichain.scene import Scene

JOINTS: dict[str, Any] = {"damping": [0.3, 0.1, 0.2], "stiffness": [2.0, 0.5, 1.5]}
SIZES: dict[str, Any] = {"links": 3, "mass": [0.7, 1.1, 0.4], "length": [0.5, 0.8, 0.3]}
OFFSET: dict[str, Any] = {"com": [0.2, 0.8, 0.1]}
CART: dict[str, Any] = {"base": "cart", "cart_mass": 0.9}
SCENES = {
    "planar": Scene("a", **SIZES, **OFFSET, actuated="all"),
    "adjacent": Scene("a", **SIZES, **OFFSET, **JOINTS, angles="adjacent", actuated="all"),
    "absolute-cart": Scene("a", **SIZES, **JOINTS, **CART, angles="absolute", actuated="all"),
    "relative-cart": Scene("a", **SIZES, **OFFSET, **JOINTS, **CART, actuated=[2, 3]),
    "spatial": Scene("a", space="spatial", **SIZES, **OFFSET, **JOINTS),
    "spatial-cart": Scene("a", space="spatial", **SIZES, **JOINTS, **CART),
}

scenes = pytest.mark.parametrize("scene", SCENES.values(), ids=SCENES.keys())
planar = pytest.mark.parametrize("scene", [s for s in SCENES.values() if s.is_planar])
spatial = pytest.mark.parametrize("scene", [s for s in SCENES.values() if not s.is_planar])


def state(scene: Scene, seed: int = 1) -> dict[str, list[Any]]:
    """Return random inputs; spatial ones exactly consistent to 100 digits."""
    draw = random.Random(seed)
    sizes = {"q": scene.nq, "v": scene.nv, "u": scene.nu, "a": scene.nv}
    inputs = {name: [mpf(draw.uniform(-1.5, 1.5)) for _ in range(size)] for name, size in sizes.items()}
    if not scene.is_planar:
        exact = reference(scene, "project", inputs, digits=100)
        inputs |= {"q": exact["q_out"], "v": exact["v_out"]}
    return inputs


def configuration_rate(scene: Scene, inputs: dict[str, list[Any]]) -> list[Any]:
    """Return q' by plain cross products."""
    if scene.is_planar:
        return inputs["v"]
    carts = 2 if scene.has_cart else 0
    rate = list(inputs["v"][:carts])
    for k in range(carts, scene.nq, 3):
        (a, b, c), (x, y, z) = inputs["v"][k : k + 3], inputs["q"][k : k + 3]
        rate += [b * z - c * y, c * x - a * z, a * y - b * x]
    return rate
