"""The loops form does not grow with the chain: the code of 64 links is that of 8, but for the numbers in it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from phichain.scene import Scene
from phichain.scene_functions import PLANAR_FUNCTIONS, SPATIAL_FUNCTIONS
from tests.generated.compiling import compiled, text_bytes, write_c

_RUNTIME = {"mass": "runtime", "length": "runtime", "com": "runtime", "gravity": "runtime"}
_JOINTS = {"damping": 0.1, "stiffness": 2.0}
_CART = {"base": "cart", "cart_mass": 1.5}
KINDS: dict[str, tuple[str, dict[str, Any]]] = {
    "planar, torques": ("planar", {"com": 0.4, "actuated": "all"}),
    "planar, tips, cart": ("planar", {**_CART, "angles": "absolute"}),
    "planar, runtime, joints, cart": ("planar", {**_CART, **_RUNTIME, **_JOINTS, "angles": "adjacent"}),
    "spatial, tips, cart": ("spatial", _CART),
    "spatial, tips, joints": ("spatial", _JOINTS),
    "spatial, mid, runtime": ("spatial", _RUNTIME),
}
SLACK = 64  # bytes of alignment and of longer immediates, which weigh in small functions


def bytes_by_function(kind: str, links: int, folder: Path) -> dict[str, int]:
    """Code of each function compiled by itself, for size."""
    space, keys = KINDS[kind]
    numbers = {"mass": 0.3, "length": 0.7} | keys
    functions = SPATIAL_FUNCTIONS if space == "spatial" else PLANAR_FUNCTIONS
    sizes = {}
    for function in functions:
        if function.startswith("phi") and "damping" in keys:
            continue
        scene = Scene(f"chain{links}", links, space=space, want=[function], code="loops", **numbers)
        sizes[function] = text_bytes(compiled(write_c(scene, folder), "-std=c99", "-Os"))
    return sizes


@pytest.mark.parametrize("kind", KINDS)
def test_loops_cost_the_same_code_for_any_number_of_links(kind: str, tmp_path: Path) -> None:
    short, long = (bytes_by_function(kind, links, tmp_path) for links in (8, 64))
    growth = {name: long[name] / short[name] for name in short if abs(long[name] - short[name]) > SLACK}
    assert {name: round(factor, 3) for name, factor in growth.items() if not 0.9 <= factor <= 1.1} == {}
