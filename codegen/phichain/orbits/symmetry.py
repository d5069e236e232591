"""Events of brake orbits: where a symmetry breaks, a family turns, or stability is lost, each a simple zero of a smooth function.

With the blocks of `quarter.QuarterMap`, mu = 1 where d^T a has a second null vector, mu = -1 where b^T c = d^T a - 1 has one:

    det [J; t] = 0                another family of brake orbits crosses, or covers this one        (core: BranchPoint)
    det [d v; g^T 0] = 0          orbits that never stand still branch off                          brake loss
    dV . t = 0                    the energy turns                                                  energy extremum
    det b = 0                     orbits odd about T/4 that are not brake orbits branch off         odd loss
    det c = 0                     brake orbits between two unequal rests branch off                 unequal brakes
    disc(kappa) = 0, |kappa| < 1  two pairs of multipliers meet on the unit circle                  krein

On a K-fold cover of an elliptic orbit mu touches 1 with both of its vectors: the brake is lost where the families cross.
"""

from __future__ import annotations

from collections.abc import Collection
from typing import Final

import numpy as np

from phichain.continuation import Branch, BranchPoint, Fold, Point, Problem, Quantity, Special, TestFunction
from phichain.continuation.events import signed
from phichain.continuation.problem import Multipliers
from phichain.orbits.krein import signs
from phichain.orbits.quarter import QuarterMap

BRANCH_POINT: Final = "branch point"
AT_EQUILIBRIUM: Final = "rest at an equilibrium"
MOST_UNSTABLE: Final = 1e12
"""|kappa| beyond which nothing smaller beside it has digits left, and the tests are rounding: a family ends there."""
_BESIDE: Final = 1e-3
"""Arclength within which what turns at the end of a family is found."""
SAID: Final[dict[str, tuple[str, str]]] = {
    "fold omega": ("no symmetry: the frequency turns", "this family"),
    "fold amplitude": ("no symmetry: this angle turns", "this family"),
    "energy extremum": ("no symmetry: the energy turns, and stability changes", "this family"),
    "brake loss": ("the rest: orbits beside it never stand still", "orbits with theta(t + T/2) = -theta(t), over a half period"),
    "odd loss": ("the rest and theta(t + T/2) = -theta(t)", "orbits odd about T/4, over a half period"),
    "unequal brakes": ("theta(t + T/2) = -theta(t)", "brake orbits between two unequal rests, over a half period"),
    "krein": ("no symmetry: two pairs of multipliers leave the unit circle", "this family; tori, which no method here follows, branch off"),
    "cover": ("the shorter period of the family that it covers", "that family, over its own quarter period"),
    AT_EQUILIBRIUM: ("nothing: the rest comes to an equilibrium, and the period grows without bound", "connections of that equilibrium"),
    BRANCH_POINT: (
        "no symmetry: another family of brake orbits crosses, or turns away closer by than 2e-6, which rounding does not tell apart",
        "brake orbits, over a quarter period",
    ),
}
"""What every kind of event breaks, and which problem goes on beyond it."""


def _of(point: Point) -> QuarterMap:
    found: QuarterMap = point.extra.found
    return found


def _odd(blocks: QuarterMap) -> float:
    return signed(blocks.b)


def _unequal(blocks: QuarterMap) -> float:
    return signed(blocks.c)


def brake_loss(point: Point) -> float:
    """det [d v; g^T 0], v and g the null vectors that d has on every orbit."""
    return _of(point).test("brake loss", _loss)


def _loss(blocks: QuarterMap) -> float:
    size = len(blocks.force)
    bordered = np.zeros((size + 1, size + 1))
    bordered[:size, :size], bordered[:size, size], bordered[size, :size] = blocks.d, blocks.rate, blocks.force
    return signed(bordered)


def _signs(point: Point) -> tuple[int, ...] | None:
    blocks = _of(point)
    return signs(blocks.a, blocks.c, blocks.d)


def discriminant(point: Point) -> float:
    """That of all kappa of a point."""
    return discriminant_of(point.multipliers)


def discriminant_of(kappa: Multipliers) -> float:
    """prod (kappa_i - kappa_j)^2 over all pairs: real, and smooth where two meet."""
    rows, columns = np.triu_indices(len(kappa), 1)
    return float(np.prod((kappa[rows] - kappa[columns]) ** 2).real)


def too_unstable() -> TestFunction:
    """Where the largest |kappa| leaves the others no digits; the family ends there."""

    def excess(point: Point) -> float:
        return _largest(point) - MOST_UNSTABLE

    return Quantity(excess, "unstable beyond double precision", terminal=True, known="largest kappa", less=MOST_UNSTABLE)


def _largest(point: Point) -> float:
    """The largest |kappa|, or of any other orbit the largest of its multipliers."""
    found = point.extra.found
    if isinstance(found, QuarterMap):
        return found.test("largest kappa", lambda own: max(map(abs, own.kappa().tolist())))
    return max(map(abs, point.extra.multipliers.tolist()))


def ended_by(branch: Branch, kinds: Collection[str]) -> tuple[list[Special], Special | None]:
    """The events of a family without those that only seem to turn where it ends, and the one of these kinds that ended it."""
    events = list(branch.events)
    if branch.status != "event" or events[-1].kind not in kinds:
        return events, None
    last = events.pop()
    return [event for event in events if last.arclength - event.arclength > _BESIDE], last


def tests_of(problem: Problem, carts: int, links: int) -> list[TestFunction]:
    """The test functions of a family of brake orbits."""

    sizes = problem.sizes[carts:-1]

    def energy_slope(point: Point) -> float:
        # Where the tangent is not the null vector of the Jacobian, nobody has asked for sigma.
        return _rise(_of(point), point) if point.sigma is None else _of(point).test("energy slope", lambda found: _rise(found, point))

    def _rise(found: QuarterMap, point: Point) -> float:
        return float(found.slope @ (point.tangent[carts:-1] * sizes))

    several: list[TestFunction] = [
        Quantity(brake_loss, "brake loss", known="brake loss"),
        Quantity(lambda point: _of(point).test("odd loss", _odd), "odd loss", known="odd loss"),
        Quantity(lambda point: _of(point).test("unequal brakes", _unequal), "unequal brakes", known="unequal brakes"),
        BranchPoint(BRANCH_POINT),
        too_unstable(),
    ]
    return [
        Fold(name="fold omega"),
        *(Fold(carts + k, f"fold amplitude {k + 1}") for k in range(links)),
        Quantity(energy_slope, "energy extremum", known="energy slope"),
        *(several if links > 1 else []),
        *([Quantity(discriminant, "krein", in_pairs=True, order=_signs)] if links > 2 else []),
    ]


def told(event: Special) -> Special:
    """The event with what it breaks and what goes on beyond."""
    word = event.kind.split(" of ")[0].rstrip("0123456789 ")
    breaks, continues = SAID.get(word, ("", ""))
    return Special.made(**vars(event) | {"breaks": breaks, "continues": continues})


def genuine(event: Special) -> bool:
    """False where two kappa meet off the interval from -1 to 1: no stability is lost where there was none."""
    return event.kind != "krein" or _meets_inside(event)


def _meets_inside(event: Special) -> bool:
    """Whether the two kappa that are closest lie inside the interval from -1 to 1."""
    kappa = event.multipliers
    rows, columns = np.triu_indices(len(kappa), 1)
    closest = int(np.argmin(np.abs(kappa[rows] - kappa[columns])))
    return bool(abs(kappa[rows[closest]].real) < 1)
