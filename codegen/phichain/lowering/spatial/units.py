"""Each link's own units in the spatial articulated sweep: m of mass and l of length.

In them no number of the sweep grows with l / r: inertias are sums of masses, determinants products of them, and what the
rotation of a link with its mass near the joint leaves to divide by shrinks with (r / l)^4 where nothing beyond holds the link.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import Final

from phichain.ir.builder import ArrayRef, Builder, Expr, Index
from phichain.lowering.chain.parameters import Parameters
from phichain.scene import Scene

#: Links that feel less of each other's squared rates turn alone: more than a digit of what they turn by may be lost beside those.
LEAST_FELT: Final = 0.05

#: Ratio of inertias from which on the third body from the tip meets the last two links as a dyad: two more digits than it may lose.
LARGEST_SQUARED: Final = 100


class SpatialUnits:
    """Per-link numbers; what link k passes on to link k - 1 changes units on the way, and link 0 keeps its own.

    Attributes:
        reach: beta = r / l, of rigid links that of their points (`body`), which have to be somewhere.
        reach_squared: beta^2, the link's inertia against turning about its joint.
        overhang: 1 - beta = (l - r) / l.
        overhang_squared: (1 - beta)^2.
        lever: beta (1 - beta).
        inverse_torque: 1 / (m l^2), takes a couple into the link's units.
        mass_unit: m, kg.
        mass: takes a mass from link k to link k - 1.
        length: takes a length or an acceleration from link k to link k - 1.
        outward: takes a length or an acceleration from link k - 1 to link k.
    """

    def __init__(self, builder: Builder, scene: Scene, parameters: Parameters) -> None:
        length, derived, steps = parameters.length, parameters.derived, parameters.steps
        self.mass_unit = mass = parameters.mass if parameters.bodies is None else parameters.bodies.point
        self.reach, over = _reach(parameters)
        reach = self.reach
        self.reach_squared = derived("reach_squared", lambda k: reach[k] * reach[k])
        self.overhang = overhang = derived("overhang_share", over)
        self.overhang_squared = derived("overhang_squared", lambda k: overhang[k] * overhang[k])
        self.lever = derived("tip_lever", lambda k: reach[k] * overhang[k])
        self.inverse_torque = derived("over_end_inertia", lambda k: 1 / (mass[k] * length[k] * length[k]))
        self.mass = steps("link_mass_step", lambda k: mass[k])
        self.length = steps("length_step", lambda k: length[k])
        self.outward = steps("outward_step", lambda k: 1 / length[k])


def _reach(parameters: Parameters) -> tuple[ArrayRef, Callable[[Index], Expr]]:
    """beta, and how to make 1 - beta; of rigid links b / (a l) and (a l - b) / (a l)."""
    length, com, bodies, derived = parameters.length, parameters.com, parameters.bodies, parameters.derived
    if bodies is None:
        return derived("reach", lambda k: com[k] / length[k]), lambda k: (length[k] - com[k]) / length[k]
    over = derived("inverse_reach_moment", lambda k: 1 / (bodies.first[k] * length[k]))
    return derived("reach", lambda k: bodies.second[k] * over[k]), lambda k: bodies.lever[k] * over[k]


class MobilityScales:
    """Per-link numbers; mobilities are kept as -mu W, mu a mass of the link, so that a uniform chain has few factors.

    Attributes:
        own: b_k.
        lever: kappa_k.
        pivot: b_k plus what is isotropic in the G of link k + 1, (1 - beta)^2 m.
        slack: takes a mobility of link k + 1 to what it takes from that, kappa^2 / mu.
        lean: kappa_k / mu_k, of which a joint's acceleration is carried on.
        push: kappa_{k+1} / mu_k.
        base_slack, base_overhang: the same two of link 0, kappa^2 / mu and (1 - beta)^2 m.
        scale: mu_k.
    """

    def __init__(self, parameters: Parameters) -> None:
        mass, length, com, last = parameters.mass, parameters.length, parameters.com, parameters.links - 1
        derived = parameters.derived

        def lever(k: Index) -> Expr:
            return mass[k] * com[k] * (length[k] - com[k]) / (length[k] * length[k])

        def scale_of(k: Index) -> Expr:
            return mass[k] if lever(k).is_zero else lever(k)

        def overhang(k: Index) -> Expr:
            short = length[k] - com[k]
            return mass[k] * short * short / (length[k] * length[k])

        def beyond(k: Index) -> int:
            assert isinstance(k, int)  # all numbers are known where this form serves
            return min(k + 1, last)

        self.own = own = derived("own_inertia", lambda k: mass[k] * com[k] * com[k] / (length[k] * length[k]))
        self.lever = derived("joint_lever", lever)
        self.scale = derived("mobility_scale", scale_of)
        self.pivot = derived("pivot_inertia", lambda k: own[k] + overhang(beyond(k)))
        self.slack = derived("slack", lambda k: lever(beyond(k)) * lever(beyond(k)) / scale_of(beyond(k)))
        self.lean = derived("lean_share", lambda k: lever(k) / scale_of(k))
        self.base_slack = lever(0) * lever(0) / scale_of(0)
        self.base_overhang = overhang(0)
        self.push = derived("push_share", lambda k: lever(beyond(k)) / scale_of(k))


def amplification(links: Sequence[tuple[float, float]], cart_mass: float | None) -> float:
    """How many units of rounding what a link meets beyond it is off by, over the link's own inertia: the largest of all.

    With g = (1 - beta) / beta, an error of G or of d beyond a link leaves it as g^2 or g times itself, since
    kappa W <= g, beside the link's own rounding, at most (1 - beta)^2 m or kappa m. The tip's own joint has no G.

    Args:
        links: (m, beta) from the base on.
        cart_mass: None on a fixed base.
    """
    inertia, force, worst = 0.0, 0.0, 0.0
    for place, (mass, beta) in enumerate(reversed(links)):
        own, over = mass * beta * beta, 1 - beta
        worst = max(worst, inertia / own, force / own)
        growth = abs(over) / beta
        inertia, force = growth * growth * inertia, growth * force
        if place:
            inertia, force = inertia + mass * over * over, force + mass * beta * abs(over)
    return worst if cart_mass is None else max(worst, inertia / cart_mass, force / cart_mass)


def turns_alone(scene: Scene) -> bool:
    """Whether two links hardly feel each other's turning: both accelerations may be small beside the squares of their rates.

    With a and b the moments of a link and of the masses beyond about its joint, w_0^2 reaches the tip as l_0 a_1 w_0^2 / b_1, the tip's link 0
    as l_0 a_1 w_1^2 / b_0, and a cart gives back a_0^2 w_0^2 / (b_0 (m_c + m_0 + m_1)). A balanced wheel at the end of a rod feels nothing;
    links alike feel as much as their own. Of more links the sweep's G holds as much rounding as what this saves.

    Args:
        scene: a chain of points whose numbers are known.
    """
    links, length = known_links(scene), scene.length
    if scene.links != 2 or links is None or isinstance(length, str):
        return False
    (inner, outer), (mass, tip) = (float(beta * l) for (_, beta), l in zip(links, length, strict=True)), (float(m) for m, _ in links)
    long = float(length[0])
    first, second = mass * inner + tip * long, mass * inner * inner + tip * long * long
    felt = max(long / outer, long * tip * outer / second)
    if scene.has_cart and isinstance(scene.cart_mass, int | float | Fraction):
        felt = max(felt, first * first / (second * (float(scene.cart_mass) + mass + tip)))
    return felt < LEAST_FELT


def squares_loss(scene: Scene) -> bool:
    """Whether the third body from the tip would lose by the square of an angle what it needs the last two links for.

    All that it meets across its own direction is one dyad, of at most (1 - beta)^2 m of the link beyond, beside its own beta^2 m, or the
    mass of a cart: only where the first is much more does it matter that the dyad's rounding is none of its own.

    Args:
        scene: a chain of points; False where its numbers are not known.
    """
    links = None if scene.inertia is not None else known_links(scene)
    if links is None or len(links) < 2:
        return False
    if len(links) > 2:
        before, share = links[-3]
        own = before * share * share
    elif scene.cart_mass is None or isinstance(scene.cart_mass, str):
        return False
    else:
        own = scene.cart_mass
    mass, beta = links[-2]
    return mass * (1 - beta) * (1 - beta) > LARGEST_SQUARED * own


def known_links(scene: Scene) -> list[tuple[float, float]] | None:
    """(m, beta) of every link; None where some of it is a runtime parameter."""
    mass, com, length = scene.mass, scene.com or scene.length, scene.length
    if isinstance(mass, str) or isinstance(com, str) or isinstance(length, str):
        return None
    return [(m, r / l) for m, r, l in zip(mass, com, length, strict=True)]
