"""The kinds of orbits by their symmetries: which problem closes each, what its unknowns mean, and what its
events open.

With S: theta -> -theta half a period later, R: reversal of time about a rest, R S: reversal about the
straight chain,

    quarter   S, R and R S   brake orbits
    unequal   R              brake orbits between two unequal rests
    odd       R S            odd about their passages through the straight chain
    half      S              theta(t + T/2) = -theta(t), never at rest
    whole     none

Every event that breaks a symmetry opens the kind that has what is left.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from phichain.continuation import BranchPoint, Fold, Level, Point, Problem, Quantity, Special, TestFunction
from phichain.continuation.events import signed
from phichain.orbits.closed.reversible import HalfMap, reversible_problem
from phichain.orbits.closed.symmetries import gains, recognised
from phichain.orbits.krein import signs, signs_of_symplectic
from phichain.orbits.periodic import PeriodMap, half_problem, whole_problem
from phichain.orbits.quarter import quarter_problem
from phichain.orbits.symmetry import BRANCH_POINT, SAID, discriminant, tests_of, too_unstable
from phichain.system import Parameters, System, Vector

_STILL: Final = 0.06
"""Angles, rad, and rates in frequencies, below which a family is its linear mode, as good as back at rest."""
_SLOW: Final = 1e-3
"""Share of its first frequency at which there is none left."""
PERIOD_DOUBLING: Final = "period doubling"
SYMMETRY_LOSS: Final = "symmetry loss"
PHASE_LOSS: Final = "phase loss"
"""Two extrema of the potential energy along the orbits become one, and with them the place where they are
taken up."""


@dataclass(frozen=True)
class Kind:
    """One kind of orbits.

    Attributes:
        name: Its name.
        words: What is followed, and over which part of the period.
        opens: Event -> (the kind that it opens, how many of its own periods are one of that).
    """

    name: str
    words: str
    opens: dict[str, tuple[str, int]]


KINDS: Final = {
    kind.name: kind
    for kind in (
        Kind("quarter", "brake orbits, over a quarter period", {
            "brake loss": ("half", 1), "odd loss": ("odd", 1), "unequal brakes": ("unequal", 1), BRANCH_POINT: ("quarter", 1),
        }),
        Kind("unequal", "brake orbits between two unequal rests, over a half period", {
            "brake loss": ("whole", 1), PERIOD_DOUBLING: ("unequal", 2), BRANCH_POINT: ("unequal", 1),
        }),
        Kind("odd", "orbits odd about T/4, over a half period", {
            "odd loss": ("whole", 1), PERIOD_DOUBLING: ("odd", 2), BRANCH_POINT: ("odd", 1),
        }),
        Kind("half", "orbits with theta(t + T/2) = -theta(t), over a half period", {
            SYMMETRY_LOSS: ("whole", 1), BRANCH_POINT: ("half", 1), PHASE_LOSS: ("half", 1),
        }),
        Kind("whole", "orbits without symmetry, over a full period", {
            PERIOD_DOUBLING: ("whole", 2), BRANCH_POINT: ("whole", 1), PHASE_LOSS: ("whole", 1),
        }),
    )
}  # fmt: skip


def problem_of(system: System, p: Parameters | None, kind: str, z: Vector) -> Problem:
    """The problem that closes a kind of orbits, sized by one of them, z."""
    omega = float(z[-1])
    if kind == "quarter":
        return quarter_problem(system, p, omega=omega, shape=z[:-1])
    if kind in ("unequal", "odd"):
        return reversible_problem(system, p, rests=kind == "unequal", omega=omega)
    return (half_problem if kind == "half" else whole_problem)(system, p, omega=omega)


def state_of(kind: str, z: Vector) -> tuple[Vector, Vector]:
    """(q, v) at the start of the orbit z, (nq,) each."""
    if kind in ("quarter", "unequal"):
        return z[:-1], np.zeros(len(z) - 1)
    if kind == "odd":
        return np.zeros(len(z) - 1), z[:-1]
    half = (len(z) - 2) // 2
    return z[:half], z[half : 2 * half]


def unknowns_of(kind: str, q: Vector, v: Vector, omega: float) -> Vector:
    """z of the orbit that starts at (q, v), which has to have what the kind's start has."""
    if kind in ("quarter", "unequal"):
        return np.append(q, omega)
    return np.append(v, omega) if kind == "odd" else np.concatenate([q, v, [0.0, omega]])


def events_of(system: System, p: Parameters | None, kind: str, problem: Problem) -> list[TestFunction]:
    """The test functions of a kind's families; one that comes to an orbit of more symmetries ends there."""
    carts, links = system.cart_size, system.links
    if kind == "quarter":
        return tests_of(problem, carts, links)

    def meets(problem: Problem, point: Point) -> bool:
        z = point.z(problem)
        return gains(kind, recognised(system, p, *state_of(kind, z), float(z[-1])))

    own = _reversible_tests(kind, carts, links) if kind in ("unequal", "odd") else _periodic_tests(kind, 2 * system.nq)
    several: list[TestFunction] = [
        BranchPoint(BRANCH_POINT, ends=meets),
        too_unstable(),
    ]
    return [
        Fold(name="fold omega"), *own(problem), *(several if links > 1 else []),
        *([Quantity(discriminant, "krein", in_pairs=True, order=_signs)] if links > 2 else []),
    ]  # fmt: skip


_BROKEN: Final = {
    "brake loss": "the rests: orbits beside it never stand still",
    "odd loss": "the passages through the straight chain",
    PERIOD_DOUBLING: "the period: orbits beside it come back after two",
    PHASE_LOSS: "nothing: the least potential at which these orbits are taken up is one no longer",
    SYMMETRY_LOSS: "theta(t + T/2) = -theta(t)",
    BRANCH_POINT: "no symmetry of this family: another one crosses, or orbits with more symmetries do, at which it ends",
    "krein": "no symmetry: two pairs of multipliers leave the unit circle",
    "energy extremum": "no symmetry: the energy turns, and stability changes",
    "fold omega": "no symmetry: the frequency turns",
    "fold amplitude": "no symmetry: this angle turns",
}


def said_of(kind: str, event: Special) -> Special:
    """An event of a kind other than brake orbits, with what it breaks and what goes on beyond."""
    if event.kind.startswith("cover"):
        return replace(event, breaks=SAID["cover"][0], continues="that family, over its own period")
    opened = KINDS[kind].opens.get(event.kind)
    beyond = KINDS[opened[0]].words + (", of twice the period" if opened[1] == 2 else "") if opened else "this family"
    breaks = _BROKEN.get(event.kind.rstrip("0123456789 "), "")
    return replace(event, breaks=breaks, continues=beyond if breaks else "")


def _signs(point: Point) -> tuple[int, ...] | None:
    blocks = point.extra.found
    if isinstance(blocks, PeriodMap):
        return signs_of_symplectic(blocks.symplectic)
    return signs(blocks.a, blocks.c, blocks.d)


Maker = Callable[[Problem], list[TestFunction]]


def _reversible_tests(kind: str, carts: int, links: int) -> Maker:
    def made(problem: Problem) -> list[TestFunction]:
        def of(point: Point) -> HalfMap:
            found: HalfMap = point.extra.found
            return found

        def loss(point: Point) -> float:
            blocks = of(point)
            bordered = np.block([[blocks.lost, blocks.ended[:, None]], [blocks.begun[None, :], np.zeros((1, 1))]])
            return signed(bordered)

        doublings = [
            Quantity(lambda point: signed(of(point).a), PERIOD_DOUBLING), Quantity(lambda point: signed(of(point).d), PERIOD_DOUBLING),
        ]  # fmt: skip
        folds = [Fold(carts + k, f"fold amplitude {k + 1}") for k in range(links)] if kind == "unequal" else []
        slope = Quantity(lambda point: float(of(point).slope @ point.slope(problem)[carts:-1]), "energy extremum")
        lost = Quantity(loss, "brake loss" if kind == "unequal" else "odd loss")
        return [*folds, slope, *([lost, *doublings] if links > 1 else [])]

    return made


def _periodic_tests(kind: str, states: int) -> Maker:
    def made(problem: Problem) -> list[TestFunction]:
        def of(point: Point) -> PeriodMap:
            found: PeriodMap = point.extra.found
            return found

        return [
            Quantity(lambda point: float(of(point).slope @ point.slope(problem)[:states]), "energy extremum"),
            Quantity(lambda point: float(np.prod(1 + point.multipliers).real), SYMMETRY_LOSS if kind == "half" else PERIOD_DOUBLING),
            Quantity(lambda point: of(point).turning, PHASE_LOSS, terminal=True),
        ]

    return made


def ends_of(system: System, kind: str, problem: Problem, z: Vector) -> list[TestFunction]:
    """Where families that are entered at the orbit z end: the chain at rest, no frequency left, links upside
    down at a rest."""
    carts, states = system.cart_size, slice(system.cart_size, len(z) - 1)

    def size(z: Vector) -> float:
        return float(np.max(np.abs(z[states] / problem.sizes[states])))

    ends: list[TestFunction] = [
        Level(size, small(problem, z, carts), "back at rest"), Level(lambda z: float(z[-1]), _SLOW * float(z[-1]), "omega near zero"),
    ]  # fmt: skip
    if kind in ("quarter", "unequal"):
        ends.append(Level(lambda z: float(np.max(np.abs(z[carts:-1]))), np.pi, "amplitude pi"))
    return ends


def small(problem: Problem, z: Vector, carts: int) -> float:
    """The size, in scaled unknowns, at which a family that was entered at z is back at rest; no step may be
    longer than 3/2 of it, to see it."""
    return min(_STILL, float(np.max(np.abs(z[carts:-1] / problem.sizes[carts:-1]))) / 2)
