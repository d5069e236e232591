"""From a saved family to the law that leads a chain up along it by one weak torque."""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil
from typing import Final

import numpy as np

from phichain.continuation import Branch
from phichain.control import Gains
from phichain.errors import ArrayError, ControlError
from phichain.laws import FamilyLaw, GainTable
from phichain.orbits.climb.across import asked_between, by_phase, gains_across
from phichain.orbits.climb.catch import narrowed, regulators, state_feedback
from phichain.orbits.climb.effort import torques
from phichain.orbits.climb.ladder import Ladder, finer, ladder
from phichain.orbits.climb.motion import Equations
from phichain.records import Held
from phichain.system import System, Vector
from phichain.system.arrays import positive, whole

RUNGS: Final = 48
"""Rungs at a limit of `FIVE`, and intervals between nodes."""
FIVE: Final = 0.05
MOST: Final = 240
NODES_MOST: Final = 97
"""Nodes of half a period by the limit alone."""
NODES_EVER: Final = 257
STRAY: Final = 0.5
"""Share of the limit that the law may ask for between nodes while the chain is on its orbit: of few chains those at 0.8 and below climb, two above 0.9 do not."""
TAKEN: Final = 0.5
"""Level at the last brake, at most."""
TUBE: Final = 1.0
"""Distance from the orbit beyond which the chain is calmed, rad: links that flick over within a few calls are half a radian from it for one of them."""
COST: Final = 5.0
"""Weight of the squared input across orbits, in squared gravity torques about the first joint: by its own, a tenth as large perhaps, the input
of an outer joint would weigh too much, and what it brings across an orbit is little enough."""
SPENT: Final = 1.0
"""Periods of the whole limit, as a root mean square, that the way from one rung to the next may take: what is more gets rungs in between."""
APART: Final = 0.25
"""Way from orbit to orbit, at most, in those between rungs: rungs are chosen among orbits, and those of a family traced in long steps are few."""
USED: Final = 0.5
"""Share of the limit, likewise, that rungs may rise by."""
PACE: Final = 40.0
"""Rungs a second for each gravity torque of the limit."""
RISE: Final = 20.0
"""Rungs a half period for each gravity torque of the limit."""
RISE_MOST: Final = 1.0
"""Rungs a half period, however strong the input: on its way from orbit to orbit the chain is to be near one."""
NEEDED: Final = ("forward_dynamics", "state_jacobian", "linearization", "energy", "gravity_torque")


@dataclass(frozen=True, eq=False)
class Climb(Held):
    """A law along a family, and what it was made of.

    Attributes:
        law: The law.
        ladder: The orbits of the family, all of them.
        torque: Gravity torque of the chain about the driven joint, held out level, N m.
        effort: Periods of the whole limit, as a root mean square, that the way from each rung but the first to the next takes (rungs - 2,).
        work: Most energy that the limit brings in within a period of each rung but the first (rungs - 1,), J.
        swept: Integral of every joint's squared rate over a period of it (rungs - 1, links), rad^2/s.
    """

    law: FamilyLaw
    ladder: Ladder
    torque: float
    effort: Vector
    work: Vector
    swept: Vector

    def lost(self, damping: Vector) -> Vector:
        """Energy that dampers (links,), N m s/rad, take in a period of every rung but the first, J."""
        return np.asarray(self.swept @ damping)

    def demand_room(self, damping: Vector) -> None:
        """See that the limit brings in what dampers take, twice over.

        Raises:
            ControlError: It does not; up to which energy it would.
        """
        share = self.lost(damping) / self.work
        short = np.flatnonzero(2 * share >= 1)
        if short.size:
            least = float(np.max(share) * 2 * self.law.limit)
            raise ControlError(
                "limit", self.law.limit, f"is too small for the damping: from {self.law.energies[short[0] + 1]:.4g} J on dampers take more than "
                "half of what it brings in", f"give {least:.4g} N m or more, or less damping", needed=least
            )  # fmt: skip


def fineness(share: float) -> tuple[int, int]:
    """Rungs and nodes of a table for a limit of so many gravity torques about the first joint.

    What lies between rungs and nodes is no orbit, and takes a torque to be followed; of a weak input no such share may go into that. On
    `planar2` 48 rungs of 49 nodes serve 5 % of the gravity torque, 96 of 97 serve 2 % (64 of 81 and 48 of 97 do not) and 160 of 97 serve 1 %
    (96 of 129 do not).
    """
    finer = max(1.0, FIVE / share)
    return min(MOST, ceil(RUNGS * finer**0.75)), min(NODES_MOST, 2 * ceil(RUNGS / 2 * finer**0.75) + 1)


def gravity_torque(system: System, joint: int) -> float:
    """Torque about a joint, counted from 1, of all links beyond it held out level, N m."""
    q = np.zeros(system.links)
    q[0] = np.pi / 2
    return float(abs(system.gravity_torque(q)[joint - 1]))


def climb_law(
    system: System, branch: Branch, *, share: float = 0.05, digest: str | None = None, rungs: int | None = None, nodes: int | None = None,
    sample: float = 1e-3, pace: float | None = None, rise: float | None = None, cost: float = COST,
) -> Climb:  # fmt: skip
    """The law that leads a planar chain on a fixed base, driven at one joint, up along a family of brake orbits.

    Args:
        system: The chain with one input, the torque at one joint, in relative angles, without losses.
        branch: The family; its energy rises all the way to the neighbourhood of an equilibrium.
        share: Limit of the torque, in gravity torques about the driven joint.
        digest: That of the scene that the family was traced with; the system's own unless given.
        rungs: Orbits in the table; by the limit unless given, see `fineness`.
        nodes: Nodes of half a period; by the limit, and by how far the orbits are from the cubics between them, unless given.
        sample: Time between two calls, s.
        pace: Rungs a second, at most; by the limit unless given.
        rise: Rungs a half period, at most; likewise.
        cost: Weight of the squared input across orbits, in squared gravity torques about the first joint.

    Raises:
        ArrayError: The branch belongs to another scene, or a number is none that it could be.
        ControlError: The chain is not of that kind.
        UnsupportedError: The family leads nowhere.
        ConvergenceError: It ends too far from the equilibrium for the limit, and nothing was found beyond.
    """
    if branch.digest != (digest or system.digest):
        raise ArrayError(
            "branch", branch.scene or branch.digest, f"is the scene of that branch, and '{system.name}' is another one",
            "name the scene that it was traced with",
        )  # fmt: skip
    if not system.is_planar or not system.rests or system.nu != 1 or system.angles != "relative":
        raise ControlError("system", system.name, "is no planar chain on a fixed base with one torque", 'write actuated = [1] in [joints]')
    share = positive("share", share, "give a part of the gravity torque, such as 0.05")
    joint = int(system.u_names[0].rpartition("_")[2])
    equations = Equations(system)
    torque, swing = gravity_torque(system, joint), _slowest_swing(equations)
    limit = share * torque
    whole_torque = gravity_torque(system, 1)
    usual = fineness(limit / whole_torque)
    rungs = whole("rungs", usual[0] if rungs is None else rungs, 4, 1000, "give a number of orbits", ArrayError)
    count = whole("nodes", usual[1] if nodes is None else nodes, 9, 1000, "give a number of nodes", ArrayError)
    weights = np.concatenate([np.ones(system.nq), np.full(system.nv, swing**2)])
    chosen: list[tuple[Gains, GainTable]] = []

    def is_near(brake: Vector) -> bool:
        if not chosen:
            signs = tuple(int(np.sign(np.cos(angle))) for angle in np.cumsum(brake[: system.nq]))
            chosen.extend(regulators(system, signs, weights, torque, limit, sample))
        return min(float(table.level(0, brake)) for _, table in chosen) <= TAKEN

    found = ladder(system, branch, equations, is_near)
    regulator, table = min(chosen, key=lambda one: float(one[1].level(0, found.states[-1, 0])))
    effort = torques(equations, found.states, found.periods, weights) / limit
    states, t, rates = by_phase(equations, found.states, found.periods, weights, count)
    parts = np.ceil(_way(states, weights, rungs - 1, effort) / APART).astype(int)
    if np.any(parts > 1):
        found = finer(system, equations, found, np.maximum(parts, 1))
        effort = torques(equations, found.states, found.periods, weights) / limit
        states, t, rates = by_phase(equations, found.states, found.periods, weights, count)
    kept = _spread(_way(states, weights, rungs - 1, effort), rungs - 1)
    while True:
        states, t, rates = by_phase(equations, found.states[kept], found.periods[kept], weights, count)
        slowness = _slowness(states)
        gains = gains_across(equations, states, t, slowness, cost / whole_torque**2)
        asked = float(np.max(asked_between(states, gains))) / limit
        if nodes is not None or asked <= STRAY or count == NODES_EVER:
            break
        count = min(NODES_EVER, 2 * ceil((count - 1) / 2 * 1.05 * (asked / STRAY) ** (1 / 3)) + 1)
    at_rest = np.zeros((1, count, system.nx))
    speeds = np.abs(states[:, :, system.nq :])
    swept = 2 * np.sum((speeds[:, 1:] ** 2 + speeds[:, :-1] ** 2) / 2 * np.diff(t, axis=1)[:, :, None], axis=1)
    driven = speeds[:, :, joint - 1]
    work = 2 * limit * np.sum((driven[:, 1:] + driven[:, :-1]) / 2 * np.diff(t, axis=1), axis=1)
    spent = np.maximum(np.diff(np.concatenate([[0.0], np.cumsum(effort)])[kept]), 1e-9)
    most = min(RISE_MOST, RISE * share) if rise is None else rise
    rises = np.concatenate([[most], np.minimum(most, USED / 2 / spent), [most]])
    law = FamilyLaw(
        state_feedback(table), narrowed(equations, regulator, table, weights), np.concatenate([at_rest, states]), np.concatenate([rates[:1], rates]),
        np.concatenate([gains[:1], gains]), weights, np.concatenate([slowness[:1], slowness]), rises, np.concatenate([[0.0], found.energies[kept]]),
        np.concatenate([found.periods[kept][:1], found.periods[kept]]), PACE * share if pace is None else pace, TUBE,
    )  # fmt: skip
    return Climb(law, found, torque, spent, work, swept)


def _slowness(states: Vector) -> Vector:
    """What squared rates are weighed by across each orbit (orbits,), s^2: squared angles over squared rates, both along the orbit."""
    half = states.shape[2] // 2
    return np.asarray(np.sum(states[:, :, :half] ** 2, axis=(1, 2)) / np.sum(states[:, :, half:] ** 2, axis=(1, 2)))


def _slowest_swing(equations: Equations) -> float:
    """Time in which the hanging chain's slowest mode turns by one radian of its phase, s: what rates are weighed by."""
    A, _ = equations.slopes(np.zeros((1, equations.system.nx)))
    return float(1 / np.min(np.abs(np.linalg.eigvals(A[0]).imag)))


def _way(states: Vector, weights: Vector, count: int, effort: Vector) -> Vector:
    """Ways from orbit to orbit (orbits - 1,), of all of them count - 1 for so many rungs, and more where they take effort.

    Half of them goes with the distance d, half with d sqrt(|d^2 x / ds^2|), in which the motions halfway between rungs, that are no orbits,
    err alike.
    """
    steps = np.sqrt(weights) * np.diff(states, axis=0)
    apart = np.max(np.linalg.norm(steps, axis=2), axis=1)
    turned = np.max(np.linalg.norm(np.diff(steps / apart[:, None, None], axis=0), axis=2), axis=1) / (apart[1:] + apart[:-1]) * 2
    turned = np.concatenate([turned[:1], turned, turned[-1:]])
    bent = apart * np.sqrt((turned[1:] + turned[:-1]) / 2)
    return np.asarray(np.maximum((apart / np.sum(apart) + bent / np.sum(bent)) / 2 * (count - 1), effort / SPENT))


def _spread(ways: Vector, count: int) -> Vector:
    """Numbers of so many orbits, evenly far along the way, the first and the last among them; of more where it is longer than they."""
    way = np.concatenate([[0.0], np.cumsum(ways)])
    return np.unique(np.searchsorted(way, np.linspace(0, way[-1], max(count, ceil(way[-1] - 1e-9) + 1)) - 1e-12 * way[-1]))
