"""What a finished run cannot vouch for: its phase, and which side of a separatrix it took.

An undamped chain without input keeps its energy, and a separatrix runs at the energy of each unstable equilibrium. A run
whose energy drifted by more than its distance to one of them may have crossed over. Beside a separatrix the period changes
with the logarithm of that distance, so that a drift dE over a time T puts the phase off by about T |v| dE / distance, and
farther away by less. And a start so near to an equilibrium that a step's increment is lost in rounding stays there. Such
runs end with status "doubtful" and say why.

The 2^N equilibria are not looked up one by one: the one that a state can be near has every link where it leans to, and since
the potential is linear in the links' directions the energies of all follow from those of N + 1.
"""

from __future__ import annotations

from collections.abc import Callable
from math import inf, isfinite
from typing import Final

import numpy as np

from phichain.motion.path import Path
from phichain.motion.problem import Problem
from phichain.system import Parameters, System, Vector
from phichain.system.angles import absolute_angles
from phichain.system.vertical import configuration

#: Energies of 2^N equilibria are compared up to this many links; beyond, they lie too close to tell anything.
MOST_LINKS: Final = 8
#: A drift below this many units of round-off is none.
ROUND_OFF_DRIFT: Final = 100.0
#: Nearer to an unstable equilibrium than this (rad), plain sums lose what moves the chain away from it.
TOO_NEAR: Final = 1e-12
#: Phase errors up to this are what a tolerance is chosen for, rad.
MOST_PHASE: Final = 0.01
#: Methods that sum with compensation and measure their errors by the motion.
COMPENSATED: Final = ("taylor",)


def doubts(problem: Problem, path: Path, name: str, energy: Callable[[], Vector | None]) -> list[str]:
    """Reasons to doubt a run, as sentences; none for damped, driven or sprung chains, or those on a cart.

    Args:
        problem: What was integrated.
        path: What was found.
        name: The method.
        energy: Total energy along the path (m,), J, or None where the system has none; asked only where it matters.
    """
    energies = energy() if _is_conservative(problem) and problem.system.links <= MOST_LINKS else None
    if energies is None:
        return []
    found = []
    if name not in COMPENSATED:
        near = _distance(problem.system, problem.x0)
        if 0 < near < TOO_NEAR:
            found.append(
                f"doubtful: the start is {near:.2g} rad from an unstable equilibrium, and the plain sums of {name} "
                "may not tell it from there; use the Taylor flow (propagate)"
            )
    return [*found, *_drifted(problem, path, energies)]


def _drifted(problem: Problem, path: Path, energies: Vector) -> list[str]:
    lowest, highest = float(energies.min()), float(energies.max())
    if not isfinite(highest - lowest):
        return []
    first, unit = float(energies[0]), ROUND_OFF_DRIFT * float(np.finfo(float).eps)
    drift = max(highest - first, first - lowest)
    if drift <= unit * max(abs(lowest), abs(highest)):
        return []
    levels = _levels(problem)
    gap = float(np.min(np.abs(levels - first)))
    if drift <= unit * float(np.max(np.abs(levels))):
        return []
    why = f"the energy drifted by {drift:.2g} J and an unstable equilibrium's is {gap:.2g} J away"
    remedy = "lower tol, or use the Taylor flow (propagate) at round-off"
    if drift >= gap:
        return [f"doubtful: {why}, so which side of it the motion takes is not known; {remedy}"]
    phase = float(abs(path.t[-1] - path.t[0]) * np.max(np.abs(path.x[:, problem.system.nq :])) * drift / gap)
    if phase > MOST_PHASE:
        return [f"doubtful: {why}, which puts the motion's phase off by some {phase:.2g} rad; {remedy}"]
    return []


def _is_conservative(problem: Problem) -> bool:
    system = problem.system
    return system.joints.is_free and problem.control is None and system.rests and system.real == "double"


def _levels(problem: Problem) -> Vector:
    """Energies of all equilibria but the hanging one, J: what turning a link up costs is the same wherever the others are."""
    system = problem.system
    directions = 1 - 2 * np.eye(system.links + 1, system.links, -1, dtype=int)  # all hanging, then one upright each
    states = np.array([configuration(system, tuple(row)) for row in directions])
    hanging, *raised = total_energy(system, states, np.zeros((len(states), system.nv)), problem.p)
    levels = np.array([hanging])
    for energy in raised:
        levels = np.concatenate([levels, levels + (energy - hanging)])
    return levels[1:]


def total_energy(system: System, q: Vector, v: Vector, p: Parameters | None) -> Vector:
    """T + V of states (m, nq) and (m, nv), J."""
    kinetic, potential = system.energy(q, v, **system.parameters(p))
    return np.asarray(kinetic + potential, dtype=float)


def _distance(system: System, x: Vector) -> float:
    """How far a state is from the unstable equilibrium it may be near: its largest lean (rad) or rate (rad/s).

    That is the one with every link up or down as it leans; infinite where that is the hanging one, or a link lies level.
    """
    q, v = x[: system.nq], x[system.nq :]
    if system.is_planar:
        phi = absolute_angles(system, q)
        down, aside = np.cos(phi), np.abs(np.sin(phi))
    else:
        links = q.reshape(-1, 3)
        down, aside = links[:, 2], np.linalg.norm(links[:, :2], axis=1)
    if not np.all(down != 0) or np.all(down > 0):
        return inf
    return float(max(np.max(aside), np.max(np.abs(v))))
