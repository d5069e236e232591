"""Rigid links as what the sweeps know: point masses that move alike, or moments about joints (theory section 1).

T and V see a link by three numbers alone: mass, first moment and second moment about its joint. A mass at a link's outer end is one
at the next link's base, so a link of mass m at r with inertia J, and e left over at its outer end by the link beyond, is the
point mass a^2 / b at b / a from its joint and what is left of the masses, at the joint itself:

    a = m r + l e,   b = m r^2 + J + l^2 e,   e' = m + e - a^2 / b = (m (J + e (l - r)^2) + e J) / b

From the tip inwards, e' being the e of the link before; at the base it belongs to a cart and to nothing on a wall. Neither
a l - b = m r (l - r) - J nor e' is a difference of what e brings along. Links of known numbers are folded exactly
before anything is written, so that a chain of rods has the operations of a chain of points.

A link whose first moment is zero (com = 0 at the tip) or small has its point mass nowhere or far away: `point_masses` leaves such a
chain as it is, and its forms use a, b and a l - b.
"""

from __future__ import annotations

from collections.abc import Callable
from copy import copy
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from math import inf
from typing import Any, Final

from phichain.ir.builder import ArrayRef, Builder, Expr, Index
from phichain.scene import Scene

Derived = Callable[[str, Callable[[Index], Expr]], ArrayRef]

#: A point mass further out than so many lengths of its link costs the forms that measure by it their last digits.
_FARTHEST: Final = 4
#: Links up to which numbers are folded: the digits of exact fractions grow along the chain.
_LONGEST: Final = 64


@dataclass(frozen=True)
class Moments:
    """A chain's links in exact numbers, from the base on.

    Attributes:
        first: a_k, kg m.
        second: b_k, kg m^2.
        left: what is left at joint 0, kg.
    """

    first: tuple[Fraction, ...]
    second: tuple[Fraction, ...]
    left: Fraction


def is_known(scene: Scene) -> bool:
    """Whether all that a, b and e are made of are numbers, of few enough links."""
    given = scene.mass, scene.length, scene.com, scene.inertia
    return scene.links <= _LONGEST and not any(isinstance(values, str) for values in given)


def is_folded(scene: Scene) -> bool:
    """Whether tables of masses, places and lengths, and of what is made of them, are constants."""
    if scene.inertia is not None:
        return is_known(scene)
    return not any(isinstance(values, str) for values in (scene.mass, scene.length, scene.com))


def moments(scene: Scene) -> Moments:
    """a_k and b_k of a chain whose numbers are known."""
    length = _exact(scene.length)
    com = length if scene.com is None else _exact(scene.com)
    first, second, left = [], [], Fraction(0)
    for m, l, r, spin in reversed([*zip(_exact(scene.mass), length, com, _exact(scene.inertia), strict=True)]):
        a, b = m * r + l * left, m * r * r + spin + l * l * left
        first.append(a)
        second.append(b)
        left += m - a * a / b
    return Moments(tuple(first[::-1]), tuple(second[::-1]), left)


@lru_cache(maxsize=16)
def point_masses(scene: Scene) -> Scene:
    """The chain of point masses that moves as a chain of rigid links does, its numbers exact fractions.

    A scene without inertia is returned as it is, and so is one whose numbers are not known or whose points would lie too far out.
    """
    if scene.inertia is None or not is_known(scene):
        return scene
    found, length = moments(scene), _exact(scene.length)
    numbers = list(zip(found.first, found.second, length, strict=True))
    # the spatial forms measure by no such ratio
    farthest = _FARTHEST if scene.is_planar else inf
    if any(not a or b > farthest * a * l for a, b, l in numbers):
        return scene
    com = tuple(b / a for a, b, _ in numbers)
    changed: dict[str, Any] = {
        "mass": tuple(a * a / b for a, b, _ in numbers), "com": None if com == length else com, "inertia": None,
    }  # fmt: skip
    if scene.has_cart and isinstance(scene.cart_mass, int | float):
        changed["cart_mass"] = Fraction(scene.cart_mass) + found.left
    view = copy(scene)
    for name, value in changed.items():
        object.__setattr__(view, name, value)
    return view


def has_points(scene: Scene) -> bool:
    """Whether no link can be held at its centre of mass, whatever its runtime parameters: all have a point mass somewhere."""
    return scene.com != "runtime" and all(scene.com or (1.0,))


def _exact(values: Any) -> tuple[Fraction, ...]:
    return tuple(map(Fraction, values))


@dataclass(frozen=True)
class Links:
    """A chain's numbers as tables of a Program: m_k, l_k, r_k and J_k."""

    mass: ArrayRef
    length: ArrayRef
    com: ArrayRef
    inertia: ArrayRef


class Bodies:
    """Tables of a chain of rigid links in a Program, in SI units.

    Attributes:
        first: a_k.
        second: b_k.
        over_second: 1 / b_k.
        left: what is left at joint 0.
        lever: a_k l_k - b_k.
    """

    def __init__(self, builder: Builder, scene: Scene, links: Links, derived: Derived) -> None:
        """Fold the numbers, or record their recurrence.

        Args:
            builder: where the Program is recorded.
            scene: the chain.
            links: its numbers.
            derived: makes a table of per-link values.
        """
        self._derived = derived
        if is_known(scene):
            found = moments(scene)
            self.first = builder.constants("first_moment", found.first)
            self.second = builder.constants("second_moment", found.second)
            self.over_second = builder.constants("inverse_second_moment", [1 / b for b in found.second])
            self.left = builder.lift(found.left)
        else:
            self.first, self.second, self.over_second, self.left = _tables(builder, scene.links, links)
        mass, length, com, inertia = links.mass, links.length, links.com, links.inertia
        self.lever = derived("lever_moment", lambda k: mass[k] * com[k] * (length[k] - com[k]) - inertia[k])

    @property
    def point(self) -> ArrayRef:
        """a^2 / b, the mass of the point."""
        return self._derived("point_mass", lambda k: self.first[k] * self.first[k] * self.over_second[k])

    @property
    def beyond(self) -> ArrayRef:
        """(a l - b)^2 / b, the point mass times the square of how far it is from the link's end."""
        return self._derived("end_moment", lambda k: self.lever[k] * self.lever[k] * self.over_second[k])


def _tables(builder: Builder, count: int, links: Links) -> tuple[ArrayRef, ArrayRef, ArrayRef, Expr]:
    """a, b, 1 / b and what is left at joint 0, computed once a call from the tip inwards."""
    let = builder.let
    first, second, over = (builder.array(name, count) for name in ("first_moment", "second_moment", "inverse_second_moment"))
    with builder.loop("k", count - 1, -1, -1) as loop:
        k = loop.index
        m, l, r, spin = links.mass[k], links.length[k], links.com[k], links.inertia[k]
        end = loop.carry("end_mass", 0)
        reach, held = let("own_moment", m * r), let("end_moment", l * end)
        apart = let("length_beyond", l - r)
        b = let("link_moment", reach * r + spin + l * held)
        inverse = let("inverse_moment", 1 / b)
        first[k], second[k], over[k] = reach + held, b, inverse
        loop.follow(end, (m * (spin + end * (apart * apart)) + end * spin) * inverse)
    return first, second, over, end
