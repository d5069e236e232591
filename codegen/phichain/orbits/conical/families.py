"""Conical families followed: every relative equilibrium of a spatial chain that turns with its links in one vertical plane.

For two links, and for any number whose masses sit at the links' ends, these are all there are: sum_j (Omega^2 c_ij - lambda_i delta_ij) q_j
has no horizontal part, and the inverse of c is tridiagonal there, so that the horizontal parts of the links are multiples of one vector.
With N = 2 they are the branches of the double spherical pendulum's diagram.

Source: J. Marsden, J. Scheurle, Lagrangian reduction and the double spherical pendulum, ZAMP 44 (1993) 17-43.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from phichain.continuation import (
    Branch,
    BranchPoint,
    Engine,
    Fold,
    Level,
    Options,
    Point,
    Problem,
    Quantity,
    Special,
    TestFunction,
    follow,
    predictors,
    start_on,
)
from phichain.continuation.events import signed
from phichain.orbits.conical.problem import Beside, angular_momentum, conical_problem
from phichain.orbits.conical.starts import FASTEST, METHOD, Start, conical_starts
from phichain.orbits.conical.turning import turning
from phichain.orbits.run import Run
from phichain.orbits.targets import Target
from phichain.system import Parameters, System, Vector

START = 1e-2
"""Largest angle off an equilibrium of a family's first point, rad."""
FLAT = "omega without bound"
REST = "at an equilibrium"
_SAME = 1e-3
"""Distance of unknowns within which the end of one family is the beginning of another."""
_SAID = {
    "fold omega": ("no symmetry: the rate turns", "this family"),
    "energy extremum": ("no symmetry: energy and angular momentum turn together, and stability may change", "this family"),
    "out of plane": ("the mirror symmetry: links leave their common vertical plane", "relative equilibria that no method here follows"),
    "krein": ("no symmetry: two pairs of exponents leave the imaginary axis", "this family"),
    "branch point": ("no symmetry: another conical family crosses", "conical"),
}


def settings(options: Options | None) -> Engine:
    """Predictor, corrector and options of a conical family."""
    return Engine(predictors.cubic, options=options or Options(step=0.01, step_max=0.1, max_points=5000, tol=1e-9))


def trace_conical(
    system: System,
    starts: Sequence[Start],
    mode: int,
    target: Target | None,
    run: Run,
) -> Branch:
    """Follow one conical family from where it begins.

    Args:
        system: A spatial chain.
        starts: Its beginnings, `conical_starts`.
        mode: Number of the one, from 1; 1 .. N are the hanging chain's.
        target: Where to end; None for an equilibrium, or 5 times the hanging chain's fastest frequency, where the links lie flat.
        run: How it is followed.

    Returns:
        The Branch of (theta, Omega), theta_k the angle of link k from the hanging vertical in the plane that turns, with energy and angular
        momentum; its multipliers are kappa = cosh(s T) with the exponents s of the turning frame.

    Raises:
        ConvergenceError: Newton did not reach the family.
    """
    start = starts[mode - 1]
    problem = conical_problem(system, run.p, omega=starts[0].omega)
    fastest = max((s.omega for s in starts if s.is_flat), default=FASTEST * max(s.omega for s in starts if not s.base.any()))
    tests = _tests(system, problem, target, fastest, run.amplitude_start)
    first: Branch | Point = run.earlier if run.earlier is not None else start_on(problem, *_beginning(start, run.amplitude_start), run.engine, fixed=True)
    branch = follow(problem, first, run.engine, tests, f"{system.name}, conical {mode} ({start.where})", through=run.through, progress=run.progress)
    events = tuple(_told(system, event) for event in _kept(branch.events))
    momentum = np.array([angular_momentum(system, z, run.p) for z in branch.points])
    states = np.array([turning(system, z).x for z in branch.points])
    return replace(
        branch, events=events, momentum=momentum, states=states, scene=system.name, digest=system.digest, method=METHOD, mode=mode,
        p=system.values(run.p),
    )


def conical_families(system: System, p: Parameters | None = None, engine: Engine | None = None) -> tuple[Branch, ...]:
    """All conical families that begin at an equilibrium or come from infinity, each once.

    Raises:
        UnsupportedError: The system has none, or lacks what they need.
    """
    starts = conical_starts(system, p)
    found: list[Branch] = []
    for number, start in enumerate(starts, 1):
        if not any(_ends_at(system, branch, start) for branch in found):
            found.append(trace_conical(system, starts, number, None, Run(engine or settings(None), p)))
    return tuple(found)


def _beginning(start: Start, amplitude: float) -> tuple[Vector, Vector]:
    """A guess and the unknown that the first point keeps, both (n + 1,)."""
    guess = np.append(start.base + amplitude * start.shape, start.omega)
    kept = np.zeros(len(guess))
    if start.is_flat:
        kept[-1] = -1.0
    else:
        kept[int(np.argmax(np.isclose(start.shape, 1.0)))] = 1.0
    return guess, kept


def events_of(system: System, problem: Problem) -> list[TestFunction]:
    """The test functions of a conical family."""

    def beside(point: Point) -> Beside:
        found: Beside = point.extra.found
        return found

    def discriminant(point: Point) -> float:
        squares = beside(point).squares / point.z(problem)[-1] ** 2
        rows, columns = np.triu_indices(len(squares), 1)
        return float(np.prod((squares[rows] - squares[columns]) ** 2).real)

    several = [Quantity(lambda point: signed(beside(point).across), "out of plane"), Quantity(discriminant, "krein")]
    return [
        Fold(name="fold omega"),
        BranchPoint(),
        Quantity(lambda point: signed(beside(point).reduced), "energy extremum"),
        *(several if system.links > 1 else []),
    ]


def _tests(system: System, problem: Problem, target: Target | None, fastest: float, start: float) -> list[TestFunction]:
    on_cart = int(system.has_cart)
    return [
        *events_of(system, problem),
        *([target.level(system, problem, on_cart)] if target is not None else []),
        Level(lambda z: float(np.max(np.abs(np.sin(z[on_cart:-1])))), start / 2, REST),
        Level(lambda z: float(z[-1]), fastest * (1 + 1e-9), FLAT),
    ]


def _kept(events: tuple[Special, ...]) -> list[Special]:
    """Without collisions off the imaginary axis, and without the energy's double where the plane is left."""
    left = [event.arclength for event in events if event.kind == "out of plane"]
    return [
        event
        for event in events
        if not (event.kind == "energy extremum" and any(abs(event.arclength - s) < _SAME for s in left))
        and not (event.kind == "krein" and not _on_axis(event))
    ]


def _on_axis(event: Special) -> bool:
    """Whether the two kappa that are closest lie inside the interval from -1 to 1."""
    kappa = event.multipliers
    rows, columns = np.triu_indices(len(kappa), 1)
    closest = int(np.argmin(np.abs(kappa[rows] - kappa[columns])))
    return bool(abs(kappa[rows[closest]].real) < 1)


def _told(system: System, event: Special) -> Special:
    breaks, continues = _SAID.get(event.kind, ("", ""))
    return replace(event, breaks=breaks, continues=continues, state=turning(system, event.z).x)


def _ends_at(system: System, branch: Branch, start: Start) -> bool:
    """Whether a family was followed to where another begins."""
    if branch.status != "event":
        return False
    last, on_cart = branch.points[-1], int(system.has_cart)
    own = start.base[on_cart:]
    # A mirror image is the same family, and so is one whose angles are whole turns away.
    off = min(float(np.max(np.abs(np.angle(np.exp(1j * (sign * last[on_cart:-1] - own)))))) for sign in (1, -1))
    if start.is_flat:
        return branch.events[-1].kind == FLAT and off < 1e-6
    return branch.events[-1].kind == REST and off < 2 * START and abs(last[-1] / start.omega - 1) < _SAME
