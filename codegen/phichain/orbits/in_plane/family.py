"""Brake orbits of spatial chains in a vertical plane, followed from a linear mode, with the places where they lose their plane."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from phichain.continuation import Branch, Point, Problem, Quantity, Special, TestFunction, follow, start_on
from phichain.errors import UnsupportedError
from phichain.orbits import shooting
from phichain.orbits.conical.starts import Start, conical_starts
from phichain.orbits.in_plane.problem import METHOD, NEEDED, SpatialMap, at_rest, plane_problem
from phichain.orbits.run import Run
from phichain.orbits.symmetry import discriminant_of, genuine, tests_of, told
from phichain.orbits.targets import Target
from phichain.system import Parameters, System

START = shooting.START
settings = shooting.settings
PLANE_LOSS = "plane loss"
_SAID = ("the plane: orbits beside it leave it", "orbits that come back turned, method 'whirling'")


def plane_modes(system: System, p: Parameters | None = None) -> tuple[Start, ...]:
    """The linear modes of a hanging spatial chain, by rising frequency: those of conical families.

    Raises:
        UnsupportedError: The chain is planar, loses energy, or lacks what its orbits need.
    """
    if system.is_planar:
        raise UnsupportedError("method", METHOD, "is for spatial chains", 'use method = "shooting"')
    if not (system.has("propagate") and system.variational and system.real == "double"):
        raise UnsupportedError(
            "method", METHOD, f"system '{system.name}' lacks a double precision flow that carries derivatives",
            f"build its scene with [functions] want = {list(NEEDED)} and [flow] variational = true",
        )  # fmt: skip
    return tuple(start for start in conical_starts(system, p) if not start.is_flat and not start.base.any())


def _to(sign: float) -> Callable[[Point], float]:
    """Point -> how far the multipliers of motions out of the plane are from mu = sign: a product with simple zeros."""

    def product(point: Point) -> float:
        found: SpatialMap = point.extra.found
        return float(np.prod(found.across - sign).real)

    return product


def events_of(system: System, problem: Problem) -> list[TestFunction]:
    """The test functions of a family of orbits in a plane."""
    tests = [test for test in tests_of(problem, 0, system.links) if test.name != "krein"]
    if system.links > 2:
        tests.append(Quantity(lambda point: discriminant_of(point.extra.found.within), "krein"))
    if system.links > 1:
        tests += [Quantity(_to(sign), PLANE_LOSS) for sign in (1.0, -1.0)]
    return tests


def _told(system: System, event: Special) -> Special:
    state = at_rest(system, event.z).x
    if event.kind == PLANE_LOSS:
        return replace(event, breaks=_SAID[0], continues=_SAID[1], state=state)
    return replace(told(event), state=state)


def trace_in_plane(
    system: System,
    modes: tuple[Start, ...],
    mode: int,
    target: Target,
    run: Run,
) -> Branch:
    """Follow the brake orbits in a plane that one linear mode starts.

    Args:
        system: A spatial chain.
        modes: Its modes, `plane_modes`.
        mode: Number of the mode, from 1.
        target: Where to end; theta_K is the angle of link K from the hanging vertical.
        run: How it is followed.

    Raises:
        ConvergenceError: Newton did not reach the family.
    """
    begun = modes[mode - 1]
    problem = plane_problem(system, run.p, omega=begun.omega)
    tests = [*events_of(system, problem), *shooting.ends(system, problem, target, run.amplitude_start, begun.omega, 0)]
    tests += shooting.equilibrium_end(problem, 0)
    shape = begun.shape[int(system.has_cart) :]
    first = run.earlier if run.earlier is not None else start_on(
        problem, np.append(run.amplitude_start * shape, begun.omega), shooting.axis(shape), run.engine, fixed=True
    )  # fmt: skip
    branch = follow(problem, first, run.engine, tests, f"{system.name}, mode {mode}, in a plane", through=run.through, progress=run.progress)
    events = tuple(_told(system, event) for event in branch.events if genuine(event))
    states = np.array([at_rest(system, z).x for z in branch.points])
    return replace(branch, events=events, states=states, closing=METHOD)
