"""The loops form does not grow with the chain: the code of 64 links is that of 8, but for the numbers in it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from phichain.scene import Scene
from tests.generated.compiling import bytes_of_functions, compiled, write_c
from tests.offered import offered

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
SLACK = 64
"""Bytes: alignment and longer immediates weigh in small functions."""


def code(kind: str, links: int, folder: Path) -> dict[str, int]:
    """Bytes of code of each function, compiled for size."""
    space, keys = KINDS[kind]
    want = offered(space, "damping" in keys, flows=True)
    numbers = {"mass": 0.3, "length": 0.7} | keys
    scene = Scene("chain", links, space=space, want=want, code="loops", **numbers)
    return bytes_of_functions(compiled(write_c(scene, folder), "-std=c99", "-Os", "-fno-inline"))


@pytest.mark.long
@pytest.mark.parametrize("kind", KINDS)
def test_loops_cost_the_same_code_for_any_number_of_links(kind: str, tmp_path: Path) -> None:
    # Above 48 links Jacobians keep two rows of states instead of all: another function.
    short, long = (code(kind, links, tmp_path) for links in (16, 40))
    assert short.keys() == long.keys() and len(short) >= 8
    assert sum(long.values()) == pytest.approx(sum(short.values()), rel=0.1)
    grown = {name: (short[name], long[name]) for name in short if long[name] > 1.1 * short[name] + SLACK}
    assert grown == {}
