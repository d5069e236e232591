"""What a scene says of the processor that its C is for: trigonometry, and limits of flash and stack."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from phichain.errors import SceneError, UnsupportedError
from phichain.scene.checks.name import function_name
from phichain.scene.checks.validate import choice, whole_number
from phichain.scene.keys import label

TRIGONOMETRY: Final = ("libm", "bundled", "hook")
"""By the C library, by code of our own alone, or by a function of the user's."""

_ON_VECTORS: Final = ("forward_dynamics_batch", "propagate_batch")
_MOST_BYTES: Final = 2**31 - 1


def trig_of(value: object, hook: object, want: Sequence[str], name: str) -> tuple[str | None, str | None]:
    """Who computes sines and cosines, and the name of the user's function where that is the user.

    Args:
        value: `"libm"`, `"bundled"`, `"hook"`, or None for the vectorised kernel with the C library beyond its range.
        hook: The function, which the scene's own code then calls; its declaration stands in NAME.h.
        want: The wanted functions.
        name: The scene's name.

    Raises:
        SceneError: It is none of these, or a hook is not declared, or one is that nobody calls.
        UnsupportedError: A function wanted runs on vectors, which have but the one kernel.
    """
    if value is None:
        if hook is not None:
            raise SceneError(label("trig_hook"), hook, "is declared and not asked for", 'set trig = "hook", or remove it')
        return None, None
    chosen = choice("trig", value, TRIGONOMETRY)
    for function in want:
        if function in _ON_VECTORS:
            problem = f"has no form on vectors, which {function} computes on"
            raise UnsupportedError(label("trig"), value, problem, f"leave trig out, or {function}")
    if chosen != "hook":
        if hook is not None:
            raise SceneError(label("trig_hook"), hook, "is declared and not asked for", 'set trig = "hook", or remove it')
        return chosen, None
    if hook is None:
        raise SceneError(
            label("trig"), value, "asks for a function that is not declared",
            'name it, as trig_hook = "my_sincos" for void my_sincos(NAME_real angle, NAME_real *sine, NAME_real *cosine)',
        )  # fmt: skip
    called = function_name(label("trig_hook"), hook)
    if called.lower().startswith(name.lower() + "_"):
        raise SceneError(label("trig_hook"), hook, "is a name of the generated code's", "choose another name")
    return chosen, called


def limit(key: str, value: object) -> int | None:
    """A limit in bytes, or None.

    Raises:
        SceneError: It is no whole number above zero.
    """
    return None if value is None else whole_number(key, value, 1, _MOST_BYTES)
