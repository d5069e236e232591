"""Families of brake orbits traced by many harmonics, checked by shooting near resonances, and handed to it where the series get too long."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from phichain.continuation import (
    Branch,
    BranchPoint,
    Extremum,
    Fold,
    Point,
    Problem,
    TestFunction,
    follow,
    start_on,
)
from phichain.errors import UnsupportedError
from phichain.orbits import shooting
from phichain.orbits.harmonics import balance
from phichain.orbits.harmonics.condensed import condensed_problem
from phichain.orbits.harmonics.elimination import Harmonics, Series
from phichain.orbits.harmonics.judge import AGREED, Judge, cut
from phichain.orbits.modes import LinearModes
from phichain.orbits.run import Run
from phichain.orbits.targets import Target
from phichain.system import System

NEEDED: Final = (*balance.NEEDED, "forward_dynamics")
"""Functions that the balance and its first guesses call."""
START: Final = 1e-2
"""Largest angle of the first point, rad."""
UNRESOLVED: Final = "tail of the spectrum"
settings = shooting.settings
"""Predictor, corrector and options: the same unknowns as shooting, the same steps."""


def demand_harmonics(system: System) -> None:
    """Refuse a system whose harmonics cannot be balanced.

    Raises:
        UnsupportedError: It misses a function, or computes in single precision.
    """
    absent = [name for name in NEEDED if not system.has(name)]
    if absent or system.real != "double":
        lacks = f"the functions {', '.join(absent)}" if absent else 'double precision, [target] real = "double"'
        raise UnsupportedError(
            "method", "harmonics", f"system '{system.name}' lacks {lacks}",
            f"build its scene with [functions] want = {list(NEEDED)}, or use method = \"one harmonic\"",
        )  # fmt: skip


def trace_harmonics(
    system: System,
    modes: LinearModes,
    mode: int,
    target: Target,
    run: Run,
    *,
    harmonics: Harmonics | None = None,
) -> Branch:
    """Follow the brake orbits that one linear mode starts, as Fourier series.

    Args:
        system: The chain.
        modes: Its linear modes.
        mode: Number of the mode, from 1.
        target: Where to end.
        run: How it is followed.
        harmonics: How many are kept.

    Returns:
        The Branch of (q_0, omega), the tail of the spectrum as its error, and kappa of every point, shot from it once, where the system can
        shoot; no point of it is unresolved. Where the series got longer than
        allowed, or shooting disagrees, shooting goes on where the scene has what it needs, and the reason says so.

    Raises:
        UnsupportedError: The system misses what the balance needs.
        ConvergenceError: Newton did not reach the family.
    """
    demand_harmonics(system)
    wanted = harmonics or Harmonics()
    omega, shape = float(modes.omega[mode - 1]), modes.shapes[:, mode - 1]
    problem = condensed_problem(system, run.p, omega=omega, shape=shape, harmonics=wanted)
    judge = None if shooting.lacks(system) else Judge(system, run.p, omega, shape)
    if judge is not None:
        problem = judge.judged(problem)
    ends = shooting.ends(system, problem, target, run.amplitude_start, omega)
    tests, name = _tests(problem, system), f"{system.name}, mode {mode}, harmonics"
    if run.earlier is not None and not _is_whole(problem, run.earlier, wanted):
        branch, why = run.earlier, "the series was too long where that run ended"
    else:
        first = run.earlier if run.earlier is not None else start_on(
            problem, np.append(run.amplitude_start * shape, omega), shooting.axis(shape), run.engine, fixed=True
        )  # fmt: skip
        branch = follow(problem, first, run.engine, [*tests, _Unresolved(wanted), *ends], name, through=run.through, progress=run.progress)
        branch, why = _agreed(branch, wanted)
    if not why:
        return branch
    if judge is None:
        missing = shooting.lacks(system)
        return replace(branch, reason=f"{branch.reason}; {why}: shooting would go on, and the system lacks {missing}")
    # Series get too long before a rest is an equilibrium.
    upright = shooting.equilibrium_end(judge.problem, system.cart_size)
    return judge.goes_on(branch, why, run.engine, [*tests, *ends, *upright], name, run.through, run.progress)


def _is_whole(problem: Problem, branch: Branch, wanted: Harmonics) -> bool:
    """Whether the last of a run's own points is a series with a small tail."""
    found: Series | None = problem.evaluate(branch.points[branch.regular - 1]).extra.found
    return found is not None and found.tail <= wanted.tail


def _tests(problem: Problem, system: System) -> list[TestFunction]:
    folds = [Fold(system.cart_size + k, f"fold amplitude {k + 1}") for k in range(system.links)]
    energy = [] if problem.energy is None else [Extremum(problem.energy, "energy extremum")]
    return [Fold(name="fold omega"), *folds, BranchPoint(), *energy]


@dataclass(frozen=True)
class _Unresolved:
    """The tail of the spectrum grows beyond what is wanted, the number of harmonics being as high as it may be."""

    wanted: Harmonics
    name: str = UNRESOLVED
    terminal: bool = True

    def value(self, problem: Problem, point: Point) -> float:
        """Decades between the tail and what is wanted."""
        found: Series | None = point.extra.found
        return 1.0 if found is None else float(np.log10(max(found.tail, 1e-300) / self.wanted.tail))


def _agreed(branch: Branch, wanted: Harmonics) -> tuple[Branch, str]:
    """The branch before the first point that shooting does not find, and why harmonics do not go on, in words: empty where they do."""
    worst = max(AGREED, 10 * wanted.tail)
    bad = np.flatnonzero(np.asarray(branch.error[: branch.regular]) > worst) if branch.error is not None else np.empty(0, int)
    if bad.size:
        apart = float(np.asarray(branch.error)[bad[0]])
        return cut(branch, max(int(bad[0]), 1)), f"beside a resonance the series is {apart:.2g} from the orbit that shooting finds"
    return branch, _unresolved(branch, wanted)


def _unresolved(branch: Branch, wanted: Harmonics) -> str:
    """Why a run of harmonics broke off, in words; empty where it did not."""
    if branch.events and branch.events[-1].kind == UNRESOLVED:
        return f"the harmonics up to {wanted.most} leave a tail above {wanted.tail:g}"
    return "a higher harmonic resonates" if branch.status == "step" else ""
