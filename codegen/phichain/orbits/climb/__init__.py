"""Up a family of brake orbits by a weak torque: its orbits as rungs, regulators across them, and the law of both."""

from phichain.orbits.climb.design import Climb, climb_law, gravity_torque

__all__ = ["Climb", "climb_law", "gravity_torque"]
