"""What is held while a parameter is turned: a quantity of the orbit, or that it is an event of its family.

Each is a scalar h(q_0, omega; lambda) that stays what it was. Events of a family of brake orbits are zeros of smooth functions
(`orbits.symmetry`): with J = d theta(T/4) / d(q_0, omega), a frequency turns where J without its last column is singular, an angle
where J without that angle's is.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np

from phichain.continuation import Evaluation
from phichain.continuation.events import signed
from phichain.errors import ArrayError
from phichain.orbits.quarter import QuarterMap
from phichain.system import System, Vector

_COVER: Final = re.compile(r"cover (\d+)\b")
Scalar = Callable[[Vector, Evaluation], float]
"""(q_0, omega) and what the quarter period says of it -> h."""

_MAPS: Final[dict[str, Callable[[QuarterMap], float]]] = {
    "brake loss": lambda found: signed(_bordered(found)),
    "odd loss": lambda found: signed(found.b),
    "unequal brakes": lambda found: signed(found.c),
}


@dataclass(frozen=True)
class Held:
    """A quantity or an event.

    Attributes:
        what: its name.
        scalar: h where it is no unknown; None where it is.
        unknown: which of (q_0, omega) it is; None where it is none of them.
        is_event: whether it is zero on what is followed, so that its value is no matter.
    """

    what: str
    scalar: Scalar | None = None
    unknown: int | None = None
    is_event: bool = False


def held_of(system: System, what: str, start: Vector) -> Held:
    """What a word says is held.

    Args:
        system: the chain.
        what: "omega", "energy", "amplitude" (the angle that is largest at the start), "theta_K", or an event's kind: "fold omega",
            "fold amplitude K", "energy extremum", "brake loss", "odd loss", "unequal brakes", "krein"; or "cover K of mode J", the orbit
            being the shorter one, of mode J.
        start: (q_0, omega) of the orbit.

    Raises:
        ArrayError: it is none of these.
    """
    carts, links = system.cart_size, system.links
    angles = {f"theta_{k + 1}": carts + k for k in range(links)}
    angles["amplitude"] = carts + int(np.argmax(np.abs(start[carts:-1])))
    angles["omega"] = len(start) - 1
    if what in angles:
        return Held(what, unknown=angles[what])
    folds = {"fold omega": len(start) - 1} | {f"fold amplitude {k + 1}": carts + k for k in range(links)}
    if what in folds:
        return Held(what, _turning(folds[what]), is_event=True)
    if links > 1 and what in _MAPS:
        return Held(what, lambda z, found: _MAPS[what](found.extra.found), is_event=True)
    if what == "energy extremum":
        return Held(what, _energy_turns(carts), is_event=True)
    if links > 2 and what == "krein":
        return Held(what, lambda z, found: _discriminant(found), is_event=True)
    if what == "energy":
        return Held(what)
    if links > 1 and (covered := times_of(what)):
        return Held(what, _turning_by(covered), is_event=True)
    known = [*angles, "energy", *folds, "energy extremum", *(_MAPS if links > 1 else ()), *(["krein"] if links > 2 else []), "cover K"]
    raise ArrayError("hold", what, "is nothing that can be held here", f"use {', '.join(known)}")


def times_of(what: str) -> int:
    """K of "cover K ..."; 0 of anything else."""
    found = _COVER.match(what)
    return int(found[1]) if found else 0


def _turning_by(times: int) -> Scalar:
    """kappa = cos(2 pi j / K): traversed K times the orbit has mu = 1 with both of its vectors, which is where the family that covers it crosses.

    Which j it is is looked up at the first orbit.
    """
    chosen: list[float] = []

    def off(z: Vector, found: Evaluation) -> float:
        kappa = found.extra.multipliers.real
        if not chosen:
            turns = np.cos(2 * np.pi * np.arange(1, times // 2 + 1) / times)
            chosen.append(float(turns[np.argmin(np.min(np.abs(kappa[:, None] - turns), axis=0))]))
        return float(np.prod(kappa - chosen[0]))

    return off


def _turning(column: int) -> Scalar:
    return lambda z, found: signed(np.delete(found.jacobian * np.abs(np.where(z == 0, 1.0, z)), column, axis=1))


def _energy_turns(carts: int) -> Scalar:
    def along(z: Vector, found: Evaluation) -> float:
        tangent = np.linalg.qr(found.jacobian.T, mode="complete")[0][:, -1]
        row = np.zeros(len(z))
        row[carts:-1] = found.extra.found.slope
        return float(np.copysign(1.0, np.linalg.det(np.vstack([found.jacobian, tangent]))) * (row @ tangent))

    return along


def _bordered(found: QuarterMap) -> Vector:
    size = len(found.force)
    matrix = np.zeros((size + 1, size + 1))
    matrix[:size, :size], matrix[:size, size], matrix[size, :size] = found.d, found.rate, found.force
    return matrix


def _discriminant(found: Evaluation) -> float:
    kappa = found.extra.multipliers
    rows, columns = np.triu_indices(len(kappa), 1)
    return float(np.prod((kappa[rows] - kappa[columns]) ** 2).real)
