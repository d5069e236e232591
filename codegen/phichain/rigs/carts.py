"""Carts that a motor draws along by a belt, or drives along a rack by its pinion; and those that a stepper moves.

At the pulley's radius p a motor at a joint (`motors`) becomes a motor at a cart: mass armature / p^2, damping / p^2, force torque / p.
A stepper, or a servo in a loop of its velocity, leaves no such choice: it makes the cart accelerate as it is told, up to a limit, so that the cart's
acceleration is the input and its mass drops out of the links' motion.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import pi
from types import MappingProxyType

from phichain.errors import SceneError
from phichain.rigs.motors import Motor, at_joint
from phichain.rigs.numbers import not_negative, positive


@dataclass(frozen=True)
class CartDrive:
    """A cart and the motor that drives it, seen from the rail.

    Attributes:
        cart_mass: the cart's own and what turns with it, kg.
        cart_damping: its bearings' and the motor's, N s/m.
        force_per_input: N per V or per A; the force in u is this times the input.
        force_limit: the force at the largest input, N, on a cart at rest.
    """

    cart_mass: float
    cart_damping: float
    force_per_input: float
    force_limit: float

    @property
    def keys(self) -> Mapping[str, object]:
        """Its part of a scene."""
        return MappingProxyType({"base": "cart", "cart_mass": self.cart_mass, "cart_damping": self.cart_damping})


@dataclass(frozen=True)
class SteppedCart:
    """A cart that accelerates as it is told.

    Attributes:
        step: how far one step moves it, m.
        speed_limit: m/s.
        acceleration_limit: m/s^2, with nothing left for the links: halve it for a chain about as heavy as the cart.
    """

    step: float
    speed_limit: float
    acceleration_limit: float

    @property
    def keys(self) -> Mapping[str, object]:
        """Its part of a scene: the cart's entry of u is its acceleration."""
        return MappingProxyType({"base": "cart", "drive": "acceleration"})


def pulley_radius(teeth: int, pitch: float) -> float:
    """Radius at which a toothed belt runs, or a rack's pinion rolls: teeth pitch / 2 pi (m).

    Args:
        teeth: of the pulley or pinion.
        pitch: from tooth to tooth along the belt or the rack, m (0.002 for GT2); pi times the module of a gear.

    Raises:
        SceneError: A number is none, or has the wrong sign.
    """
    if isinstance(teeth, bool) or not isinstance(teeth, int):
        raise SceneError("teeth", teeth, "is not a whole number", "give the number of the pulley's teeth")
    return positive("teeth", teeth, "of the pulley") * positive("pitch", pitch, "m") / (2 * pi)


def belt_cart(
    motor: Motor, radius: float, cart_mass: float, gear: float = 1.0, *, voltage: float | None = None,
    current: float | None = None, cart_damping: float = 0.0, gear_efficiency: float = 1.0, pulley_inertia: float = 0.0,
) -> CartDrive:  # fmt: skip
    """A cart driven by a motor through a belt or a rack and pinion.

    Args:
        motor: its data sheet.
        radius: p of the pulley or pinion, m.
        cart_mass: what moves along the rail, belt included, links not, kg.
        gear: n, turns of the rotor for one of the pulley.
        voltage: the largest voltage, V, of a drive by voltage.
        current: the largest current, A, of a drive by current; one of the two is given.
        cart_damping: of bearings and rail, N s/m.
        gear_efficiency: eta, at most 1.
        pulley_inertia: of all that turns with the pulley, idlers included, kg m^2.

    Raises:
        SceneError: A number is none, or has the wrong sign; both limits are given, or none.
    """
    p = positive("radius", radius, "m")
    pulley = not_negative("pulley_inertia", pulley_inertia, "kg m^2")
    drive = at_joint(motor, gear, voltage=voltage, current=current, gear_efficiency=gear_efficiency, gear_inertia=pulley)
    return CartDrive(
        positive("cart_mass", cart_mass, "kg") + drive.armature / p**2,
        not_negative("cart_damping", cart_damping, "N s/m") + drive.damping / p**2,
        drive.torque_per_input / p,
        drive.torque_limit / p,
    )


def stepped_cart(
    torque: float, radius: float, cart_mass: float, steps: int, step_rate: float, *, rotor_inertia: float = 0.0
) -> SteppedCart:
    """A cart on a belt that a stepper draws.

    Args:
        torque: of the stepper at the largest rate that is used (pull-out), N m.
        radius: p of the pulley, m.
        cart_mass: what moves along the rail, links not, kg.
        steps: steps a turn, microsteps counted.
        step_rate: the largest number of steps a second, 1/s.
        rotor_inertia: of rotor and pulleys, kg m^2.

    Raises:
        SceneError: A number is none, or has the wrong sign.
    """
    if isinstance(steps, bool) or not isinstance(steps, int):
        raise SceneError("steps", steps, "is not a whole number", "give the number of steps a turn")
    p = positive("radius", radius, "m")
    step = 2 * pi * p / positive("steps", steps, "a turn")
    moved = positive("cart_mass", cart_mass, "kg") + not_negative("rotor_inertia", rotor_inertia, "kg m^2") / p**2
    return SteppedCart(step, step * positive("step_rate", step_rate, "1/s"), positive("torque", torque, "N m") / p / moved)
