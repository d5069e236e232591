"""What is forced by A cos(omega t) in a scene: the torque at a joint, the force on a cart, or an acceleration given to its base.

Amplitude and frequency are no part of a scene: they are arguments of the flow.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final, Literal

from phichain.errors import SceneError, UnsupportedError
from phichain.scene.keys import label
from phichain.scene.validate import choice, no_cart

Forced = int | Literal["cart", "base"]

_REMEDY: Final = 'use a joint such as 1, "cart" or "base"'
_AUTONOMOUS: Final = ("propagate_stiff",)
"""Flows whose method takes the equations as they stand, time not among them."""


def forcing_of(
    forced: object, axis: object, space: str, base: str, links: int, want: Sequence[str]
) -> tuple[Forced | None, int | None]:
    """Return what is forced and along which axis, counted from 1; (None, None) for a scene without forcing.

    Raises:
        SceneError: The chain has no such place, or wants no flow that the forcing could drive.
        UnsupportedError: It wants a flow that knows no forcing.
    """
    if forced is None:
        if axis is not None:
            raise SceneError(label("axis"), axis, "is the axis of a forcing, and nothing is forced", _REMEDY_FORCED)
        return None, None
    place = _place(forced, space, base, links)
    if "propagate" not in want:
        problem = "forces a flow that is not wanted"
        raise SceneError(label("forced"), forced, problem, 'add "propagate" to want; amplitude and omega are its arguments')
    for name in _AUTONOMOUS:
        if name in want:
            raise UnsupportedError(
                "functions.want", name, "knows no forcing, which the scene has", 'want "propagate" alone, or remove [forcing]'
            )
    return place, _axis(axis, place, space)


_REMEDY_FORCED: Final = f"add forcing.forced ({_REMEDY}), or remove it"


def _place(forced: object, space: str, base: str, links: int) -> Forced:
    """Return the joint, "cart" or "base" after checking that the chain has it."""
    key = label("forced")
    if isinstance(forced, int) and not isinstance(forced, bool):
        if space == "spatial":
            problem = "forces a joint by a torque, and spatial joints are not actuated"
            raise SceneError(key, forced, problem, 'use "cart" or "base"')
        if not 1 <= forced <= links:
            raise SceneError(key, forced, "is no joint of the chain", f"use a joint from 1 to {links}")
        return forced
    if not isinstance(forced, str):
        raise SceneError(key, forced, "is nothing that can be forced", _REMEDY)
    word = choice("forced", forced, ("cart", "base"))
    if word == "cart" and base != "cart":
        raise SceneError(key, forced, no_cart(base), 'use a joint, or set base = "cart"')
    if word == "base" and base != "moving":
        problem = f"forces the acceleration of a moving base, and the base is {base}"
        raise SceneError(key, forced, problem, 'set base = "moving", or use a joint')
    return "cart" if word == "cart" else "base"


def _axis(axis: Any, place: Forced, space: str) -> int | None:
    """Return along which axis a cart or a base is forced, the first unless said."""
    key = label("axis")
    if isinstance(place, int):
        if axis is not None:
            raise SceneError(key, axis, "is the axis of a cart or a base, and a joint is forced", "remove it")
        return None
    most = (1 if space == "planar" else 2) + (place == "base")
    if axis is None:
        return 1
    if isinstance(axis, bool) or not isinstance(axis, int) or not 1 <= axis <= most:
        problem = f"is no axis that this {place} can be forced along"
        remedy = "use 1" if most == 1 else f"use 1 to {most}{', the last one down' if place == 'base' else ''}"
        raise SceneError(key, axis, problem, remedy)
    return axis
