"""Which chains are eliminated from both ends, and the numbers of the links on its base's side."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from math import inf

from phichain.ir.builder import ArrayRef, Expr, Index
from phichain.lowering.chain.link_units import LinkUnits
from phichain.lowering.chain.losses import brakes_cart, ties_links
from phichain.lowering.chain.parameters import Parameters
from phichain.lowering.chain.room import saves_memory, saves_text
from phichain.scene import Scene

#: Fewer links are done sooner from the tip alone.
_FEWEST_LINKS = 5
#: The same where tables of runtime parameters for both sides come on top, and where these want memory that is dear.
_FEWEST_RUNTIME_LINKS, _FEWEST_STORED_LINKS = 6, 12
#: Couples on a chain with l/r spread further than this need the sweep from the tip alone.
_LARGEST_LEVERAGE_SPREAD = 16
#: Couples on masses spread further than this need kappa.
_LARGEST_MASS_SPREAD = 100


def suits(scene: Scene) -> bool:
    """Whether this form is the faster one and as accurate: chains of some length, with couples only on links of like l/r.

    The text of one end is shorter. Rigid links that are no points (`body`) have no l/r to measure their minors by.
    """
    if scene.inertia is not None or saves_text(scene):
        return False
    if scene.links < _fewest_links(scene):
        return False
    return not _is_driven(scene) or scene.tip_masses or _leverage_spread(scene) <= _LARGEST_LEVERAGE_SPREAD


def _fewest_links(scene: Scene) -> int:
    if not {"mass", "length", "com"} & set(scene.runtime):
        return _FEWEST_LINKS
    return _FEWEST_STORED_LINKS if saves_memory(scene) else _FEWEST_RUNTIME_LINKS


def _is_driven(scene: Scene) -> bool:
    """Whether forces or couples other than gravity act on links or cart."""
    return bool(scene.nu) or ties_links(scene) or brakes_cart(scene)


def _leverage_spread(scene: Scene) -> Fraction | float:
    if isinstance(scene.length, str) or isinstance(scene.com, str) or scene.com is None:
        return inf
    leverage = [Fraction(length) / Fraction(com) for length, com in zip(scene.length, scene.com, strict=True)]
    return max(leverage) / min(leverage)


def _mass_spread(scene: Scene) -> Fraction | float:
    if isinstance(scene.mass, str) or isinstance(scene.cart_mass, str):
        return inf
    known = [
        Fraction(mass) for mass in (*scene.mass, *([] if scene.cart_mass is None else [scene.cart_mass]))
    ]
    return max(known) / min(known)


@dataclass(frozen=True)
class Steps:
    """Numbers of each link on the base's side, and what takes its results into the units of the next link."""

    leverage_squared: ArrayRef
    overhang_squared: ArrayRef
    lever: ArrayRef
    mass: ArrayRef
    length: ArrayRef
    skew: ArrayRef
    levered: ArrayRef
    determinant: ArrayRef
    minor: ArrayRef


def steps(parameters: Parameters, units: LinkUnits, count: int) -> Steps:
    derived = parameters.derived
    leverage, overhang, mass, length, ratio = (
        units.leverage,
        units.overhang,
        units.mass,
        units.outward,
        units.leverage_step,
    )

    def table(name: str, entry: Callable[[Index], Expr]) -> ArrayRef:
        return derived(name, entry, count)

    return Steps(
        leverage_squared=table("leverage_squared", lambda k: leverage[k] * leverage[k]),
        overhang_squared=table("overhang_squared", lambda k: overhang[k] * overhang[k]),
        lever=table("lever", lambda k: leverage[k] * overhang[k]),
        mass=mass.shifted(1),
        length=length.shifted(1),
        skew=table("next_skew", lambda k: mass[k + 1] * overhang[k]),
        levered=table("next_lever", lambda k: mass[k + 1] * overhang[k] * overhang[k]),
        determinant=table(
            "next_determinant", lambda k: mass[k + 1] * mass[k + 1] * ratio[k + 1] * ratio[k + 1]
        ),
        minor=table("next_minor", lambda k: mass[k + 1] * length[k + 1] * ratio[k + 1]),
    )


@dataclass(frozen=True)
class Weight:
    """kappa, kappa / lambda and kappa / lambda^2 of each link on the base's side."""

    own: ArrayRef
    minor: ArrayRef
    determinant: ArrayRef


def weight(scene: Scene, parameters: Parameters, units: LinkUnits, count: int) -> Weight | None:
    """None where nothing needs it."""
    if not _is_driven(scene) or _mass_spread(scene) <= _LARGEST_MASS_SPREAD:
        return None
    shortening = units.shortening
    own = parameters.derived("counterweight", lambda k: parameters.mass[k + 1] * units.inverse_mass_unit[k], count)
    minor = parameters.derived("minor_counterweight", lambda k: own[k] * shortening[k], count)
    return Weight(
        own, minor, parameters.derived("determinant_counterweight", lambda k: minor[k] * shortening[k], count)
    )
