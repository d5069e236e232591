"""Writes every committed scene into a folder, the quick ones also in their other type: python -m tests.generated.processors OUT."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

from phichain import generate
from phichain.scene import Scene, load_scene, scene_from_dict

SCENES = Path(__file__).parents[2] / "scenes"
#: Scenes that are generated in both types, of every kind of chain; CasADi's C of those in double.
TWINS = (
    "firmware_cart_float", "planar3_cart", "planar4_damped_springs", "runtime_double_pendulum", "spatial4_fixed_forward_only",
    "spatial5_cart_forward_only",
)  # fmt: skip


def other_type(scene: Scene) -> Scene:
    """The same chain in its other type."""
    tables = scene.to_dict()
    real = "double" if scene.real == "float" else "float"
    return scene_from_dict({**tables, "target": {**tables["target"], "real": real}, "name": f"{scene.name}_{real}"})


def scenes() -> Iterator[Scene]:
    """Every scene of the folder scenes/, and the twins."""
    for path in sorted(SCENES.glob("*.toml")):
        yield load_scene(path)
    for name in TWINS:
        yield other_type(load_scene(SCENES / f"{name}.toml"))


if __name__ == "__main__":
    for scene in scenes():
        generate(scene, sys.argv[1], prove=False)  # integers modulo a prime, the same everywhere
