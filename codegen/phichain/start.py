"""Starting points: states, inputs and parameters from what a user types or leaves out."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from phichain.errors import ArrayError
from phichain.system import System

Vector = NDArray[np.float64]


def leaning(system: System, angle: float) -> tuple[Vector, Vector]:
    """The straight chain at rest that leans by `angle` from the hanging vertical, in the e_1-e_3 plane.

    Args:
        system: The chain; a cart stands at 0.
        angle: Radians; positive leans towards +e_1, pi stands upright.

    Returns:
        (q, v), shapes (nq,) and (nv,).
    """
    cart = np.zeros(system.cart_size)
    if not system.is_planar:
        return np.concatenate([cart, np.tile([np.sin(angle), 0.0, np.cos(angle)], system.links)]), np.zeros(system.nv)
    kind = system.scene.get("joints", {}).get("angles", "relative")
    steps = np.arange(system.links)
    # phi_k = angle for all k, solved for theta (design 1.2): phi = theta, sum of theta, theta_k + theta_{k-1}.
    share = {"absolute": steps >= 0, "relative": steps == 0, "adjacent": steps % 2 == 0}[kind]
    return np.concatenate([cart, np.where(share, angle, 0.0)]), np.zeros(system.nv)


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
        ArrayError: A word is not NAME=NUMBERS.
    """
    found: dict[str, Vector | float] = {}
    for setting in settings:
        name, equals, text = setting.partition("=")
        values = numbers(text, name.strip() or "set")
        if not equals or values is None or not values.size:
            raise ArrayError("set", setting, "is not NAME=NUMBERS", "write for example --set mass=0.5,0.25")
        found[name.strip()] = float(values[0]) if values.size == 1 else values
    return found or None
