"""What is forced by A cos(omega t) in a scene: the torque at a joint, the force on a cart, or an acceleration given to its base.

Amplitude and frequency are no part of a scene: they are arguments of the flow.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

from phichain.contract.bases import BaseLaw, axes_of, law_of, placed, places, with_place
from phichain.errors import SceneError, UnsupportedError
from phichain.scene.checks.validate import choice, no_cart
from phichain.scene.keys import label

Forced = int | str

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
    return place, _axis(axis, place, law_of(base), 2 if space == "planar" else 3)


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
    word = choice("forced", forced, places())
    fitting = with_place(word)
    if base in fitting:
        return word
    if fitting[0] in placed():
        raise SceneError(key, forced, no_cart(base), f'use a joint, or set base = "{fitting[0]}"')
    problem = f"forces the acceleration of a {fitting[0]} base, and the base is {base}"
    raise SceneError(key, forced, problem, f'set base = "{fitting[0]}", or use a joint')


def _axis(axis: Any, place: Forced, law: BaseLaw, size: int) -> int | None:
    """Return along which axis a cart or a base is forced, its first unless said."""
    key = label("axis")
    if isinstance(place, int):
        if axis is not None:
            raise SceneError(key, axis, "is the axis of a cart or a base, and a joint is forced", "remove it")
        return None
    axes = [i + 1 for i in axes_of(law.placed if law.is_placed else law.told, size)]
    if axis is None:
        return axes[0]
    if isinstance(axis, bool) or not isinstance(axis, int) or axis not in axes:
        problem = f"is no axis that this {place} can be forced along"
        down = ", the last one down" if axes[-1] == size else ""
        raise SceneError(key, axis, problem, f"use {axes[0]}" if len(axes) == 1 else f"use {axes[0]} to {axes[-1]}{down}")
    return axis
