"""What a finished run cannot vouch for: its phase, and which side of a separatrix it took.

An undamped chain without input keeps its energy, and a separatrix runs at the energy of each unstable equilibrium. A run
whose energy drifted by more than its distance to one of them may have crossed over. Beside a separatrix the period changes
with the logarithm of that distance, so that a drift dE over a time T puts the phase off by about T |v| dE / distance, and
farther away by less. And a start so near to an equilibrium that a step's increment is lost in rounding stays there. Such
runs end with status "doubtful" and say why.
"""

from __future__ import annotations

from itertools import product
from typing import Final

import numpy as np

from phichain.motion.path import Path
from phichain.motion.problem import Problem
from phichain.system import System, Vector, pack
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


def doubts(problem: Problem, path: Path, name: str) -> list[str]:
    """Reasons to doubt a run, as sentences; none for damped, driven or sprung chains, or those on a cart."""
    system = problem.system
    if not _is_conservative(problem) or system.links > MOST_LINKS:
        return []
    upright = [s for s in product((1, -1), repeat=system.links) if -1 in s]
    found = []
    if name not in COMPENSATED:
        near = min(_distance(system, problem.x0, s) for s in upright)
        if 0 < near < TOO_NEAR:
            found.append(
                f"doubtful: the start is {near:.2g} rad from an unstable equilibrium, and the plain sums of {name} "
                "may not tell it from there; use the Taylor flow (propagate)"
            )
    return [*found, *_drifted(problem, path, upright)]


def _drifted(problem: Problem, path: Path, upright: list[tuple[int, ...]]) -> list[str]:
    energies = _energies(problem, path.x)
    if not np.all(np.isfinite(energies)):
        return []
    rest = np.zeros(problem.system.nv)
    levels = _energies(problem, np.array([pack(configuration(problem.system, s), rest) for s in upright]))
    drift = float(np.max(np.abs(energies - energies[0])))
    gap = float(np.min(np.abs(levels - energies[0])))
    scale = float(max(np.max(np.abs(energies)), np.max(np.abs(levels))))
    if drift <= ROUND_OFF_DRIFT * np.finfo(float).eps * scale:
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
    if not system.joints.is_free or not system.has("energy"):
        return False
    return problem.control is None and system.base == "fixed" and system.real == "double"


def _energies(problem: Problem, x: Vector) -> Vector:
    system = problem.system
    kinetic, potential = system.energy(x[:, : system.nq], x[:, system.nq :], **system.parameters(problem.p))
    return np.asarray(kinetic + potential, dtype=float)


def _distance(system: System, x: Vector, s: tuple[int, ...]) -> float:
    """How far a state is from the equilibrium s: its largest lean (rad; infinite beyond a right angle) or rate (rad/s)."""
    q, v = x[: system.nq], x[system.nq :]
    if system.is_planar:
        phi = absolute_angles(system, q)
        down, aside = np.cos(phi), np.abs(np.sin(phi))
    else:
        links = q.reshape(-1, 3)
        down, aside = links[:, 2], np.linalg.norm(links[:, :2], axis=1)
    lean = np.where(down * s > 0, aside, np.inf)
    return float(max(np.max(lean), np.max(np.abs(v))))
