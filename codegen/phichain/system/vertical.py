"""Vertical configurations: which links hang and which stand, checked, and the state that has them there."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from phichain.errors import ControlError
from phichain.system.angles import scene_angles
from phichain.system.arrays import Vector, real_numbers
from phichain.system.system import System

Signs = tuple[int, ...]
"""Directions of the links, +1 hanging and -1 upright."""


def check_signs(system: System, s: Sequence[int]) -> Signs:
    """The directions as plain integers.

    Raises:
        ControlError: Not one +1 or -1 per link.
    """
    values = real_numbers("s", s, "give +1 for a hanging and -1 for an upright link")
    if values.shape != (system.links,) or not np.all(np.abs(values) == 1):
        raise ControlError(
            "s",
            values.tolist(),
            f"is no equilibrium: a vertical chain has one sign per link, {system.links} of them",
            "give +1 for a hanging and -1 for an upright link",
        )
    return tuple(int(value) for value in values)


def configuration(system: System, s: Sequence[int]) -> Vector:
    """q of the equilibrium s (nq,), the cart at the origin; planar angles are 0 or +-pi links apart."""
    signs = np.array(check_signs(system, s), dtype=float)
    still = np.zeros(system.cart_size)
    if not system.is_planar:
        directions = np.zeros((system.links, 3))
        directions[:, 2] = signs
        return np.concatenate([still, directions.ravel()])
    return np.concatenate([still, scene_angles(system, np.where(signs > 0, 0.0, np.pi))])
