"""The forms an expert would write by hand for the chains of the tables, over any scalar type.

CasADi and heyoka build their expressions by running these functions on their own symbols, so neither is
held back by a poorer formula than the other's, and both are given our own tension form as well. Constants are folded
before the symbols are met, and every division by a pivot is one reciprocal.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import Any

from benchmarks.chains import Chain
from benchmarks.harness import BenchmarkError
from benchmarks.peers.recursions.planar import Function, Numbers, Scalar, closed_form, link_frame, tension
from benchmarks.peers.recursions.spatial import (
    spatial_articulated,
    spatial_tension,
    spatial_tension_direct,
    spatial_tension_twisted,
)

__all__ = [
    "LABELS", "SPATIAL", "accelerations", "forms", "planar_link_frame", "spatial_articulated", "spatial_tension",
    "spatial_tension_direct",
]  # fmt: skip

_MOST_DENSE = 4
_LONGEST_RECURSION = 16
SPATIAL = {"tension": spatial_tension, "twisted": spatial_tension_twisted, "recursion": spatial_articulated}
"""The spatial forms by name; a table says which one a peer was given."""
LABELS = {
    "link frame": "", "closed form": ", closed form", "tension": ", given the tension form",
    "twisted": ", given the twisted form", "recursion": ", recursion on S^2",
}  # fmt: skip
"""How a table names them; the tension form is this project's own (design of the emitted code)."""
HYBRID = ("twisted",)
"""Forms that are no yardstick: they are in no textbook, and tell formula from emission."""


def forms(chain: Chain) -> tuple[str, ...]:
    """The forms that serve a chain, the likely best first."""
    if chain.space == "spatial":
        if not chain.tip_masses:
            return ("recursion",)
        # below three tensions both ends are one; long recursions compile for minutes and take four times as long as tensions
        recursion = ("recursion",) if chain.links <= _LONGEST_RECURSION else ()
        return ("tension", *recursion, "twisted") if chain.links > 2 else ("tension", *recursion)
    found = ["link frame"]
    if chain.tip_masses and not chain.forced and chain.cart_mass is None:
        found.insert(0, "tension")
    if 1 < chain.links <= _MOST_DENSE:
        found.append("closed form")
    return tuple(found)


def accelerations(
    chain: Chain, form: str, q: Sequence[Scalar], v: Sequence[Scalar], u: Sequence[Scalar], sin: Function, cos: Function,
    numbers: Numbers | None = None,
) -> list[Scalar]:  # fmt: skip
    """Accelerations in the chain's own coordinates.

    Args:
        chain: The chain.
        form: One of `forms`.
        q: Configuration.
        v: Rates.
        u: Inputs; empty for none.
        sin: Of the scalar type.
        cos: Of the scalar type.
        numbers: Masses, lengths and centres in place of the chain's: symbols, where they come at run time.

    Raises:
        BenchmarkError: The form does not serve.
    """
    if chain.space == "spatial":
        return SPATIAL[form](chain, q, v, u)
    c, values = chain.carts, numbers or chain
    angles, rates = list(q[c:]), list(v[c:])
    relative = chain.angles == "relative"
    spin = list(itertools.accumulate(rates)) if relative else rates
    turn = angles if relative else _differences(angles)
    moment: list[Scalar] = []
    if len(u) and not c:
        moment = [a - b for a, b in itertools.pairwise(u)] + [u[-1]] if relative else list(u)
    cart = {"cart_mass": chain.cart_mass, "force": u[0] if len(u) else 0.0} if c else {}
    if form == "link frame":
        base, found = link_frame(values, turn, spin, moment, sin, cos, **cart)
    elif form == "closed form":
        phi = list(itertools.accumulate(angles)) if relative else angles
        base, found = closed_form(values, phi, spin, moment, sin, cos, **cart)
    elif form == "tension" and not moment and not c:
        base, found = tension(values, turn, spin, sin, cos)
    else:
        raise BenchmarkError(f"the {form} form does not serve this chain")
    return [*([base] if c else []), *(_differences(found) if relative else found)]


def planar_link_frame(
    chain: Any, theta: Sequence[Scalar], rate: Sequence[Scalar], torque: Sequence[Scalar], sin: Function, cos: Function
) -> list[Scalar]:
    """The articulated sweep for relative angles on a fixed base, joint torques as they are."""
    moment = [a - b for a, b in itertools.pairwise(torque)] + [torque[-1]] if len(torque) else []
    return _differences(link_frame(chain, theta, list(itertools.accumulate(rate)), moment, sin, cos)[1])


def _differences(values: Sequence[Scalar]) -> list[Scalar]:
    return [values[0], *(b - a for a, b in itertools.pairwise(values))]
