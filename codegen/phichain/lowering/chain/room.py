"""What a target has little of."""

from __future__ import annotations

from phichain.scene import Scene


def saves_memory(scene: Scene) -> bool:
    """Whether memory is dearer than time: on targets that say who computes sines, where nothing is written for a host's vectors."""
    return scene.trig is not None


def saves_text(scene: Scene) -> bool:
    """Whether the shortest text is wanted: loops on such a target."""
    return saves_memory(scene) and scene.code == "loops"
