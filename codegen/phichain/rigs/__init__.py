"""From a data sheet to the numbers of a scene: bodies on links, motors at joints, carts on belts and racks (docs/rigs.md).

    from phichain import Scene, rigs

    arm = rigs.link(0.2, rigs.rod(0.060, 0.2), rigs.point(0.025, 0.2))        # kg, m
    scene = Scene("arm", 1, **rigs.links(arm))

Pure functions of SI numbers; what they return is frozen, says its units, and gives its part of a scene as `keys`.
"""

from __future__ import annotations

from phichain.rigs.bodies import Body, Link, box, cylinder, disc, link, links, point, rod, swung, tube
from phichain.rigs.carts import CartDrive, SteppedCart, belt_cart, pulley_radius, stepped_cart
from phichain.rigs.motors import JointDrive, Motor, at_joint, joints

__all__ = [
    "Body",
    "CartDrive",
    "JointDrive",
    "Link",
    "Motor",
    "SteppedCart",
    "at_joint",
    "belt_cart",
    "box",
    "cylinder",
    "disc",
    "joints",
    "link",
    "links",
    "point",
    "pulley_radius",
    "rod",
    "stepped_cart",
    "swung",
    "tube",
]
