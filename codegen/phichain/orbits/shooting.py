"""Families of brake orbits, traced by shooting on the emitted Taylor flow with its variational equations."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from phichain.continuation import (
    Branch,
    Engine,
    Level,
    Options,
    Point,
    Problem,
    Quantity,
    TestFunction,
    follow,
    predictors,
    start_on,
)
from phichain.continuation.linear import size
from phichain.errors import UnsupportedError
from phichain.orbits.covers import gathered, named
from phichain.orbits.modes import LinearModes
from phichain.orbits.quarter import QuarterMap, quarter_problem
from phichain.orbits.run import Run
from phichain.orbits.symmetry import AT_EQUILIBRIUM, BRANCH_POINT, genuine, tests_of, told
from phichain.orbits.targets import LARGEST, Target
from phichain.system import Parameters, System, Vector

FLAT = 3e-5
"""|dV| |theta| / 2 V of a rest below which it is an equilibrium: what is left of dV and of the family's tangent there is rounding."""
NEEDED = ("propagate", "mass_matrix", "energy")
"""Functions that shooting calls."""
SETTINGS = Options(step=0.01, step_max=0.1, max_points=5000, tol=1e-9)
_PAIR = 2
LONG = Options(step=0.01, step_max=0.2, max_points=5000, tol=1e-9, aim_angle=0.15)
"""As long as a predictor of order ten allows, where no two pairs of multipliers meet and part again within a step."""
START = 1e-2
"""Largest angle of the first point, rad: below it the digits of omega's change with amplitude are lost."""


def lacks(system: System, needed: Sequence[str] = NEEDED) -> str:
    """What shooting misses in a system, in words; empty where it misses nothing."""
    absent = [name for name in needed if not system.has(name)]
    if absent:
        return f"the functions {', '.join(absent)}"
    if not system.variational:
        return "derivatives in its flow, [flow] variational = true"
    return "" if system.real == "double" else 'double precision, [target] real = "double"'


def demand_shooting(system: System, needed: Sequence[str] = NEEDED) -> None:
    """Refuse a system that shooting cannot serve.

    Raises:
        UnsupportedError: It misses something.
    """
    if missing := lacks(system, needed):
        raise UnsupportedError(
            "method", "shooting", f"system '{system.name}' lacks {missing}",
            f"build its scene with [functions] want = {list(needed)} and [flow] variational = true, or use method = \"one harmonic\"",
        )  # fmt: skip


def settings(options: Options | None, links: int = 0) -> Engine:
    """Predictor, corrector and options of a family of brake orbits; of one or two links, steps may be longer."""
    usual = LONG if 0 < links <= _PAIR else SETTINGS
    return Engine(predictors.osculating, options=options or usual)


def trace_shooting(
    system: System,
    modes: LinearModes,
    mode: int,
    target: Target,
    run: Run,
) -> Branch:
    """Follow the brake orbits that one linear mode starts.

    Args:
        system: The chain.
        modes: Its linear modes.
        mode: Number of the mode, from 1.
        target: Where to end.
        run: How it is followed.

    Raises:
        UnsupportedError: The system misses what shooting needs.
        ConvergenceError: Newton did not reach the family.
    """
    demand_shooting(system)
    omega, shape = float(modes.omega[mode - 1]), modes.shapes[:, mode - 1]
    problem = quarter_problem(system, run.p, omega=omega, shape=shape)
    tests = [*tests_of(problem, system.cart_size, system.links), *ends(system, problem, target, run.amplitude_start, omega)]
    tests += equilibrium_end(problem, system.cart_size)
    name = f"{system.name}, mode {mode}, shooting"
    first = run.earlier if run.earlier is not None else start_on(
        problem, np.append(run.amplitude_start * shape, omega), axis(shape), run.engine, fixed=True
    )  # fmt: skip
    branch = follow(problem, first, run.engine, tests, name, through=run.through, progress=run.progress)
    return replace(finished(system, run.p, modes, branch), closing="quarter")


def finished(system: System, p: Parameters | None, modes: LinearModes, branch: Branch) -> Branch:
    """A family of brake orbits with its events under their names."""
    kept = [named(system, p, modes, event) if event.kind == BRANCH_POINT else event for event in branch.events]
    events = tuple(told(event) for event in gathered(branch, kept) if genuine(event))
    return replace(branch, events=events)


def axis(shape: Vector) -> Vector:
    """The unknown with the largest angle, which the first point keeps."""
    direction = np.zeros(len(shape) + 1)
    direction[int(np.argmax(np.isclose(np.abs(shape), 1.0)))] = np.sign(shape[int(np.argmax(np.isclose(np.abs(shape), 1.0)))])
    return direction


def ends(system: System, problem: Problem, target: Target, start: float, omega: float, carts: int | None = None) -> list[TestFunction]:
    """Where families that begin at rest end: at the target, upside down, back at rest, at no frequency.

    The first `carts` unknowns are a cart's.
    """
    carts = system.cart_size if carts is None else carts

    def amplitude(z: Vector) -> float:
        return max(map(abs, z[carts:-1].tolist()))

    angle = LARGEST if carts == system.cart_size else None
    beyond = [] if target.what == "amplitude" and target.value >= np.pi else [Level(amplitude, np.pi, "amplitude pi", of=angle)]
    return [
        target.level(system, problem, carts),
        *beyond,
        Level(amplitude, start / 2, "back at rest", of=angle),
        Level(lambda z: float(z[-1]), 1e-3 * omega, "omega near zero", of=("unknown", problem.unknowns - 1)),
    ]


def equilibrium_end(problem: Problem, carts: int) -> list[TestFunction]:
    """Where families of brake orbits end besides: at rests that are equilibria; none where the problem has no energy."""
    height = problem.energy
    if height is None:
        return []

    def steepness(point: Point) -> float:
        return point.extra.found.test("steepness", lambda found: _steepness(found, point)) - FLAT

    def _steepness(found: QuarterMap, point: Point) -> float:
        z = point.z(problem)
        return size(found.slope) * size(z[carts:-1]) / (2 * (height(z) if math.isnan(point.energy) else point.energy))

    return [Quantity(steepness, AT_EQUILIBRIUM, terminal=True, known="steepness", less=FLAT)]
