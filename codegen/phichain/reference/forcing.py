"""A forced chain at one instant: the chain with an input where it is forced, and what its inputs are then.

The torque f at joint j does the work f (dphi_j - dphi_{j-1}), phi = S theta the links' absolute angles: conjugate to the scene's own
angles it is f (S_j - S_{j-1}).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from phichain.scene import Scene


def forced_inputs(scene: Scene, u: Sequence[Any], force: Any) -> tuple[Scene, list[Any]]:
    """The chain without forcing but with more inputs, and u with the forcing's value among them.

    Args:
        scene: a forced scene.
        u: its own inputs.
        force: A cos(omega t) at the instant, N m, N or m/s^2.
    """
    joint = scene.forced if isinstance(scene.forced, int) else 0
    actuated: Any = "all" if joint else scene.actuated
    if scene.forced == "cart" and actuated == "none":
        actuated = "cart"
    whole = replace(scene, actuated=actuated, forced=None, axis=None, variational=False, want=("forward_dynamics",))
    given = dict(zip(scene.u_names, u, strict=True))
    inputs = [given.get(name, 0) for name in whole.u_names]
    if not joint:
        axes = scene.told_axes or range(whole.base_inputs)
        inputs[axes.index((scene.axis or 1) - 1)] += force
        return whole, inputs
    for i in range(1, scene.links + 1):
        turns = _turn(scene, joint, i) - _turn(scene, joint - 1, i)
        inputs[whole.base_inputs + i - 1] += turns * force
    return whole, inputs


def _turn(scene: Scene, link: int, angle: int) -> int:
    """How far a link turns with one of the scene's angles; nothing turns the wall, link 0."""
    if link == 0:
        return 0
    if scene.angles == "relative":
        return int(angle <= link)
    return int(angle == link or (scene.angles == "adjacent" and angle == link - 1))
