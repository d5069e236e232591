"""Bodies on a link, and what they are together: mass, centre of mass and inertia by parallel axes.

Places are measured along the link from its base joint, in m; the axis of every moment of inertia lies across the link, through
the body's own centre of mass, in kg m^2. Bodies are slender enough to be said by where they lie along the link: what
stands out sideways (an eccentric mass) is no body of a chain whose centres of mass lie on its links.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import fsum, pi
from types import MappingProxyType

from phichain.errors import SceneError
from phichain.rigs.numbers import not_negative, number, positive


@dataclass(frozen=True)
class Body:
    """A rigid body on a link.

    Attributes:
        mass: kg.
        place: where its centre of mass lies along the link, m from the base joint; negative behind the joint.
        inertia: about its own centre of mass, axis across the link, kg m^2.
    """

    mass: float
    place: float
    inertia: float = 0.0


@dataclass(frozen=True)
class Link:
    """A link of a chain, as a scene has it.

    Attributes:
        length: from its base joint to the next joint, or to the tip, m.
        mass: kg.
        com: distance of the centre of mass from the base joint, m.
        inertia: about the centre of mass, kg m^2.
    """

    length: float
    mass: float
    com: float
    inertia: float

    @property
    def about_joint(self) -> float:
        """The inertia about the base joint, inertia + mass com^2 (kg m^2), which many data sheets state instead."""
        return self.inertia + self.mass * self.com**2


def point(mass: float, place: float) -> Body:
    """A mass so small that it has no inertia of its own: a bearing, a screw, a tip mass.

    Args:
        mass: kg.
        place: where it is, m.

    Raises:
        SceneError: A number is none, or has the wrong sign.
    """
    return Body(positive("mass", mass, "kg"), number("place", place, "m"))


def rod(mass: float, length: float, start: float = 0.0) -> Body:
    """A slender uniform rod along the link, J = m L^2 / 12.

    Args:
        mass: kg.
        length: L, m.
        start: where its inner end is, m; negative where it reaches behind the joint.

    Raises:
        SceneError: A number is none, or has the wrong sign.
    """
    mass, length = positive("mass", mass, "kg"), positive("length", length, "m")
    return Body(mass, number("start", start, "m") + length / 2, mass * length**2 / 12)


def tube(mass: float, length: float, outer_diameter: float, inner_diameter: float = 0.0, start: float = 0.0) -> Body:
    """A tube along the link, J = m (3 (R^2 + r^2) + L^2) / 12 with the radii R and r.

    Args:
        mass: kg.
        length: L, m.
        outer_diameter: 2 R, m.
        inner_diameter: 2 r, m.
        start: where its inner end is, m.

    Raises:
        SceneError: A number is none, or has the wrong sign; the hole is wider than the tube.
    """
    along, across = rod(mass, length, start), _radii_squared(outer_diameter, inner_diameter)
    return Body(along.mass, along.place, along.inertia + along.mass * across / 4)


def cylinder(mass: float, length: float, diameter: float, start: float = 0.0) -> Body:
    """A solid cylinder along the link: a tube without a hole.

    Args:
        mass: kg.
        length: m.
        diameter: m.
        start: where its inner end is, m.

    Raises:
        SceneError: A number is none, or has the wrong sign.
    """
    return tube(mass, length, diameter, start=start)


def box(mass: float, length: float, width: float, start: float = 0.0) -> Body:
    """A bar of rectangular section along the link, J = m (L^2 + w^2) / 12.

    Args:
        mass: kg.
        length: L, m.
        width: w, its side in the plane of motion, m.
        start: where its inner end is, m.

    Raises:
        SceneError: A number is none, or has the wrong sign.
    """
    along = rod(mass, length, start)
    return Body(along.mass, along.place, along.inertia + along.mass * positive("width", width, "m") ** 2 / 12)


def disc(mass: float, diameter: float, place: float, inner_diameter: float = 0.0) -> Body:
    """A disc, ring or hinge hub that is part of the link, its axis that of the joints: J = m (R^2 + r^2) / 2.

    It turns with the link. A wheel that spins by itself is no part of a chain.

    Args:
        mass: kg.
        diameter: 2 R, m.
        place: where its centre is, m.
        inner_diameter: 2 r, m.

    Raises:
        SceneError: A number is none, or has the wrong sign; the hole is wider than the disc.
    """
    centre = point(mass, place)
    return Body(centre.mass, centre.place, centre.mass * _radii_squared(diameter, inner_diameter) / 2)


def _radii_squared(outer_diameter: object, inner_diameter: object) -> float:
    outer = positive("outer_diameter", outer_diameter, "m") / 2
    inner = not_negative("inner_diameter", inner_diameter, "m") / 2
    if inner > outer:
        problem = f"is wider than the outer diameter {2 * outer!r}"
        raise SceneError("inner_diameter", inner_diameter, problem, "give the diameter of the hole, m")
    return outer**2 + inner**2


def link(length: float, *bodies: Body) -> Link:
    """The link that several bodies make: m = sum m_i, com = sum m_i x_i / m, J = sum J_i + m_i (x_i - com)^2.

    Args:
        length: from the base joint to the next one, or to the tip, m.
        *bodies: what it consists of.

    Raises:
        SceneError: There is no body, or what is given is none; the centre of mass lies behind the joint.
    """
    length = positive("length", length, "m")
    for body in bodies:
        if not isinstance(body, Body):
            raise SceneError("bodies", body, "is not a Body", "make it by rod, tube, cylinder, box, disc or point")
    if not bodies:
        raise SceneError("bodies", bodies, "has nothing with a mass", "give at least one body, such as rod(mass, length)")
    mass = fsum(body.mass for body in bodies)
    com = fsum(body.mass * body.place for body in bodies) / mass
    if com < 0:
        problem = "puts the centre of mass behind the base joint"
        raise SceneError("com", com, problem, "turn the link round: measure places along its other side")
    inertia = fsum(body.inertia + body.mass * (body.place - com) ** 2 for body in bodies)
    return Link(length, mass, com, inertia)


def swung(length: float, mass: float, com: float, period: float, gravity: float = 9.81) -> Link:
    """A link whose inertia is measured: hung up at its base joint, J = m g com (T / 2 pi)^2 - m com^2 for small swings.

    Args:
        length: from the base joint to the next one, or to the tip, m.
        mass: kg, weighed.
        com: distance of the centre of mass from the base joint, m, balanced on an edge.
        period: T of a small swing to and fro, s; at an amplitude of 0.1 rad it is 0.06 % longer.
        gravity: m/s^2.

    Raises:
        SceneError: A number is none, or has the wrong sign; the link swings faster than a point at its centre of mass.
    """
    mass, com = positive("mass", mass, "kg"), positive("com", com, "m")
    seconds, gravity = positive("period", period, "s"), positive("gravity", gravity, "m/s^2")
    inertia = mass * com * (gravity * (seconds / (2 * pi)) ** 2 - com)
    if inertia < 0:
        least = 2 * pi * (com / gravity) ** 0.5
        problem = f"is shorter than that of a point at the centre of mass, {least:.6g}"
        raise SceneError("period", period, problem, "measure it to and fro, in s, and com from the joint, in m")
    return Link(positive("length", length, "m"), mass, com, inertia)


def links(*chain: Link) -> Mapping[str, object]:
    """The keys of a scene for its links, from the base on: `Scene("rig", 2, **links(upper, lower))`.

    Raises:
        SceneError: There is no link, or what is given is none.
    """
    for one in chain:
        if not isinstance(one, Link):
            raise SceneError("links", one, "is not a Link", "make it by link(length, body, ...), or by swung")
    if not chain:
        raise SceneError("links", chain, "is a chain without links", "give its links from the base on")
    columns = {name: [getattr(one, name) for one in chain] for name in ("mass", "length", "com", "inertia")}
    return MappingProxyType(columns)
