"""Chains whose long, light links carry heavy, short ones: a joint's acceleration is a small difference of those before it (theory section 5)."""

from __future__ import annotations

from fractions import Fraction
from itertools import accumulate

from phichain.scene import Scene

#: Roundings of a long link's acceleration that may reach a short one.
_LARGEST_LOSS: int = 16


def carries_lightly(scene: Scene) -> bool:
    """Whether accelerations alone, handed outwards, would lose digits on points whose numbers are known.

    Args:
        scene: a chain of points, on a wall or a cart.
    """
    return scene.inertia is None and scene.com != "runtime" and loss(scene) > _LARGEST_LOSS


def loss(scene: Scene) -> float:
    """By how much rounding errors of a link's acceleration grow at most on their way outwards.

    An error in the acceleration of a joint counts in lengths of the link beyond, hence grows at most by the ratio of lengths. What is
    left of that acceleration is at most as much smaller than those before as masses from there on are heavier than what
    carries them; a runtime cart may weigh nothing.

    Args:
        scene: a chain of points; 0 where masses or lengths are not known.
    """
    if isinstance(scene.mass, str) or isinstance(scene.length, str):
        return 0.0
    mass, length, carts = _exact(scene.mass), _exact(scene.length), int(scene.has_cart)
    carriers = mass
    if carts:
        carriers = [Fraction(0) if scene.cart_mass is None or isinstance(scene.cart_mass, str) else Fraction(scene.cart_mass), *mass]
    lightest, longest = [*accumulate(carriers, min)], [*accumulate(length, max)]
    heaviest = [*accumulate(reversed(mass), max)][::-1]
    worst = Fraction(0)
    # A wall gives the tip of the link on it no acceleration that would be a difference.
    for k in range(2 - carts, scene.links):
        reach, carrier = longest[k - 1] / length[k], lightest[k - 2 + carts]
        worst = max(worst, min(reach, heaviest[k - 1] / carrier) if carrier else reach)
    return float(worst)


def _exact(values: tuple[float, ...]) -> list[Fraction]:
    return [*map(Fraction, values)]
