"""What A cos(omega t) drives: the torque at a joint, the force on a cart or its acceleration, or the acceleration of a moving base."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from phichain.errors import ArrayError, UnsupportedError
from phichain.records import Held
from phichain.system import System, Vector
from phichain.system.arrays import positive, whole

_LAG: Final = {"relative": 0, "absolute": 1, "adjacent": 2}
"""How many angles before a joint's own one its torque works against, too: tau_theta = S^T tau_phi of a pair of torques on two links."""
_RANGE: Final = "give (from, to) in rad/s, such as (2, 6)"
_PLACES: Final = 'use a joint such as 1, "cart" or "base"'


@dataclass(frozen=True, eq=False)
class Forcing(Held):
    """A cos(omega t) somewhere on a planar chain.

    Attributes:
        forced: The joint, counted from 1, "cart" or "base".
        amplitude: A, N m, N or m/s^2.
        axis: Along which axis a base is accelerated, counted from 1: 1 horizontally, 2 down.
        force: Generalised force (nq,) of amplitude 1.
        base: Acceleration of a moving base of amplitude 1, along the axes that it is told; empty where the base does not move.
        told: Whether the cart's acceleration is what is given, so that its equation is x'' = A cos(omega t).
        is_odd: Whether q -> -q with half a period's shift of time maps motions onto motions.
    """

    forced: int | str
    amplitude: float
    axis: int
    force: Vector
    base: Vector
    told: bool
    is_odd: bool

    @property
    def unit(self) -> str:
        """The unit of the amplitude."""
        if self.told or self.base.size:
            return "m/s^2"
        return "N" if self.forced == "cart" else "N m"

    @property
    def place(self) -> str:
        """Where it acts, in words."""
        if self.forced == "base":
            return f"the acceleration of the base along axis {self.axis}"
        if self.forced == "cart":
            return "the acceleration of the cart" if self.told else "the force on the cart"
        return f"the torque at joint {self.forced}"


def forcing_of(system: System, forced: Any, amplitude: Any, axis: Any = None) -> Forcing:
    """The forcing that is meant; what the scene's [forcing] says where nothing is given.

    Raises:
        ArrayError: The chain has no such place or axis, or the amplitude is not positive.
        UnsupportedError: The scene is spatial.
    """
    demand_planar(system.name, system.space)
    said, along = system.forcing
    forced = said if forced is None else forced
    axis = along if axis is None else axis
    if forced is None:
        raise ArrayError(
            "forced", None, "is missing: nothing says what A cos(omega t) drives, and unforced a chain with losses comes to rest", _PLACES
        )
    if isinstance(forced, str) and forced.isdecimal():
        forced = int(forced)
    size = amplitude_of(amplitude)
    force, told = np.zeros(system.nq), False
    if forced == "base":
        if not system.is_moving:
            raise ArrayError("forced", forced, f"needs a moving base, and this one is {system.base}", 'set base = "moving", or force a joint')
        axis = whole("axis", system.drive.axes[0] + 1 if axis is None else axis, 1, 2, "use 1, horizontally, or 2, down", ArrayError)
        if axis - 1 not in system.drive.axes:
            raise ArrayError("axis", axis, "is no axis that this base is moved along", f"use {system.drive.axes[0] + 1}")
        return Forcing("base", size, axis, force, np.eye(2)[axis - 1, list(system.drive.axes)], False, axis == 1 and system.joints.rest_angle is None)
    if axis not in (None, 1):
        raise ArrayError("axis", axis, "is the axis of a moving base, and something else is forced", "leave it out")
    if forced == "cart":
        if not system.has_cart:
            raise ArrayError("forced", forced, f"needs a cart, and the base is {system.base}", 'set base = "cart", or force a joint')
        told = system.drive.accelerations > 0
        force[0] = 0.0 if told else 1.0
    elif isinstance(forced, str):
        raise ArrayError("forced", forced, "is nothing that can be forced", _PLACES)
    else:
        joint = whole("forced", forced, 1, system.links, f"use a joint from 1 to {system.links}", ArrayError)
        carts, before = system.cart_size, joint - 1 - _LAG[str(system.angles)]
        force[carts + joint - 1] += 1.0
        if before >= 0 and before != joint - 1:
            force[carts + before] -= 1.0
        forced = joint
    base = np.zeros(system.drive.accelerations if system.is_moving else 0)
    return Forcing(forced, size, 1, force, base, told, system.joints.rest_angle is None)


def demand_planar(name: str, space: str) -> None:
    """Refuse a spatial chain.

    Raises:
        UnsupportedError: It is one.
    """
    if space != "planar":
        raise UnsupportedError(
            "system", name, "is spatial, and frequency responses are those of planar chains", "use a planar scene, or simulate it"
        )


def amplitude_of(amplitude: Any) -> float:
    """A.

    Raises:
        ArrayError: It is missing, or not positive.
    """
    remedy = "give A of A cos(omega t), in N m, N or m/s^2"
    if amplitude is None:
        raise ArrayError("amplitude", None, "is missing: nothing is driven without one", remedy)
    return positive("amplitude", amplitude, remedy, ArrayError)


def range_of(omega: Any) -> tuple[float, float]:
    """From which frequency to which.

    Raises:
        ArrayError: It is no pair of two different positive numbers.
    """
    if omega is None:
        raise ArrayError("omega", None, "is missing: a forcing without a frequency is a constant load, and drives nothing periodic", _RANGE)
    try:
        start, end = omega
    except (TypeError, ValueError):
        raise ArrayError("omega", omega, "is no range of frequencies", _RANGE) from None
    low, high = (positive("omega", value, _RANGE, ArrayError) for value in (start, end))
    if low == high:
        raise ArrayError("omega", omega, "is a single frequency", _RANGE)
    return low, high
