"""Starting points: states, inputs and parameters from what a user types or leaves out."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from phichain.errors import ArrayError
from phichain.system import System
from phichain.system.angles import scene_angles

Vector = NDArray[np.float64]


def leaning(system: System, angle: float, s: Sequence[int] | None = None) -> tuple[Vector, Vector]:
    """The chain at rest with every link tilted by `angle` towards +e_1 from where it hangs or stands.

    Args:
        system: The chain; a cart stands at 0.
        angle: Radians, in the e_1-e_3 plane.
        s: +1 for a hanging link, -1 for an upright one; all hang unless given.

    Returns:
        (q, v), shapes (nq,) and (nv,).
    """
    signs = np.ones(system.links) if s is None else np.asarray(s, dtype=float)
    cart = np.zeros(system.cart_size)
    if system.is_planar:
        return np.concatenate([cart, scene_angles(system, np.where(signs > 0, angle, np.pi - angle))]), np.zeros(system.nv)
    links = np.stack([np.full(system.links, np.sin(angle)), np.zeros(system.links), signs * np.cos(angle)], axis=-1)
    return np.concatenate([cart, links.ravel()]), np.zeros(system.nv)


def upright(text: str, links: int) -> tuple[int, ...]:
    """The signs s_k of an equilibrium from the links that stand: `all`, `none`, or numbers like `2,3`.

    Raises:
        ArrayError: Something between the commas is no link of the chain.
    """
    if text in ("all", "none"):
        return ((-1,) if text == "all" else (1,)) * links
    standing = numbers(text, "up")
    if standing is None or not np.all(np.isin(standing, np.arange(1, links + 1))):
        raise ArrayError("up", text, f"is no list of links from 1 to {links}", "write all, none, or for example 2,3")
    return tuple(-1 if k in standing else 1 for k in range(1, links + 1))


def numbers(text: str | None, field: str) -> Vector | None:
    """Numbers separated by commas or spaces; None stays None.

    Raises:
        ArrayError: Something between the commas is no number.
    """
    if text is None:
        return None
    try:
        return np.array([float(word) for word in text.replace(",", " ").split()])
    except ValueError:
        raise ArrayError(field, text, "is not a list of numbers", "write them like 0.5,0,-1e-3") from None


def parameters(settings: Sequence[str]) -> dict[str, Vector | float] | None:
    """Runtime parameters from words like `mass=1,1` and `gravity=9.81`; None when there are none.

    Raises:
        ArrayError: A word is not NAME=NUMBERS, or gives values to a name that has some.
    """
    found: dict[str, Vector | float] = {}
    for setting in settings:
        name, equals, text = setting.partition("=")
        values = numbers(text, name.strip() or "set")
        if not equals or values is None or not values.size:
            raise ArrayError("set", setting, "is not NAME=NUMBERS", "write for example --set mass=0.5,0.25")
        if name.strip() in found:
            raise ArrayError("set", setting, f"gives {name.strip()} values a second time", "give each parameter once")
        found[name.strip()] = float(values[0]) if values.size == 1 else values
    return found or None
