"""Units in which Programs compute: those of a uniform chain's links, or SI, with a unit of time where forces would leave a type's range."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction

from phichain.scene import Scene


@dataclass(frozen=True)
class Units:
    """Units of mass, length and time that a Program computes in: kg, m and s. Rates that make torques stay in rad/s and m/s."""

    mass: Fraction = Fraction(1)
    length: Fraction = Fraction(1)
    time: Fraction = Fraction(1)

    @property
    def acceleration(self) -> Fraction:
        """Unit of acceleration, m/s^2."""
        return self.length / self.time**2

    @property
    def force(self) -> Fraction:
        """Unit of force, N."""
        return self.mass * self.acceleration

    @property
    def torque(self) -> Fraction:
        """Unit of torque, N m."""
        return self.force * self.length

    @property
    def inertia(self) -> Fraction:
        """Unit of a second moment of mass, kg m^2."""
        return self.mass * self.length**2

    def of(self, parameter: str) -> Fraction:
        """Unit of a parameter of the scene."""
        match parameter:
            case "mass" | "cart_mass":
                return self.mass
            case "cart_damping":
                return self.mass / self.time**2
            case "cart_friction":
                return self.force
            case "rest_angle":
                return Fraction(1)
            case "length" | "com":
                return self.length
            case "gravity":
                return self.acceleration
            case "inertia" | "armature":
                return self.inertia
        return self.torque


def units_of_links(scene: Scene) -> Units:
    """Mass and length of a uniform chain's links; SI units where links differ, are no points, or numbers come at run time.

    Masses before the ends of spatial links are measured by r (l - r) m / l^2, by which a link ties its two joints together.
    """
    if scene.runtime or scene.inertia is not None or len(set(scene.mass)) > 1 or len(set(scene.length)) > 1:
        return Units()
    mass, length = Fraction(scene.mass[0]), Fraction(scene.length[0])
    if not scene.is_planar and scene.com is not None and len(set(scene.com)) == 1:
        com = Fraction(scene.com[0])
        mass *= com * (length - com) / length**2
    return Units(mass, length)


def si(scene: Scene) -> Units:
    """SI units."""
    return Units()


def units_where(suits: Callable[[Scene], bool]) -> Callable[[Scene], Units]:
    """Units of links on scenes that suit, SI units on others."""
    return lambda scene: units_of_links(scene) if suits(scene) else Units()
