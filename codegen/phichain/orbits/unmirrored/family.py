"""Orbits without a mirror image that runs backwards, followed from where whirling families lose it."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, Final

import numpy as np

from phichain.continuation import (
    Branch,
    BranchPoint,
    Fold,
    Level,
    Point,
    Problem,
    Quantity,
    Special,
    TestFunction,
    follow,
    start_on,
)
from phichain.errors import ArrayError, ConvergenceError, UnsupportedError
from phichain.orbits.run import Run
from phichain.orbits.symmetry import BRANCH_POINT, discriminant, ended_by, genuine, too_unstable
from phichain.orbits.targets import Target
from phichain.orbits.unmirrored.doubled import beyond_doubling, twice
from phichain.orbits.unmirrored.problem import (
    METHOD,
    FreeMap,
    Lost,
    closing_of,
    problem_of_branch,
    read_closing,
    state_of_free,
    unknowns,
    unmirrored_problem,
)
from phichain.orbits.whirling.families import PERIOD_DOUBLING
from phichain.orbits.whirling.families import settings as whirling_settings
from phichain.orbits.whirling.fixed import fixed, inertia_of, read
from phichain.orbits.whirling.problem import held_value, momentum, state_of_whirl
from phichain.orbits.whirling.starts import METHOD as WHIRLING
from phichain.orbits.whirling.starts import demand_whirling, given_family
from phichain.system import Parameters, System, Vector

settings = whirling_settings
START: Final = 1e-2
REVERSAL_LOSS: Final = "reversal loss"
REGAINED: Final = "at its own mirror image"
HALVED: Final = "at half of the period"
_SINGULAR: Final = 1e-6
_SAME: Final = 1e-5
"""Distance, in angles and rates over omega, within which a state is its own reversal: orbits where families end are located to 1e-8."""
_CLOSER: Final = (1.0, 0.25, 0.0625)
"""Shares of the first amplitude that are tried in turn."""
_SLOW: Final = 1e-3
_SAMPLES: Final = 240
_SAID: Final = {
    "fold omega": ("no symmetry: the period turns", "this family"),
    "fold turn": ("no symmetry: the angle by which orbits come back turned has an extremum", "this family"),
    "energy extremum": ("no symmetry: the energy turns", "this family"),
    "momentum extremum": ("no symmetry: the angular momentum turns", "this family"),
    PERIOD_DOUBLING: ("the period: orbits beside it come back, turned, after two", "orbits of twice the period, method 'unmirrored'"),
    "krein": ("no symmetry: two pairs of multipliers leave the unit circle", "this family"),
    BRANCH_POINT: ("no symmetry of this family: another one crosses", "orbits of this kind"),
    HALVED: ("nothing: the orbits come to be some of half of the period, taken twice", "orbits of half of the period, method 'unmirrored'"),
    REGAINED: ("nothing: the orbits gain a mirror image that runs backwards", "whirling orbits"),
}


def from_whirl(system: System, start: Any, p: Parameters | None = None) -> tuple[Lost, ...]:
    """The family that opens where whirling orbits lose their reversal, or where unmirrored ones double their period; one way to leave is as the other.

    Args:
        system: A spatial chain on a fixed base.
        start: (Branch, event) of whirling or unmirrored orbits, or "FILE.json:event=K".
        p: Runtime parameters.

    Raises:
        UnsupportedError: The chain has none, or only one family passes there.
        ArrayError: It is no such event.
    """
    demand_whirling(system, METHOD)
    branch, event = given_family(start, (WHIRLING, METHOD))
    if branch.digest != system.digest:
        raise ArrayError("start", branch.digest, f"is the digest of that branch's scene, and {system.digest!r} is wanted here", "use its scene")
    if not isinstance(event, Special) or event.kind != (opens := {WHIRLING: REVERSAL_LOSS, METHOD: PERIOD_DOUBLING}[branch.method]):
        remedy = f'give (Branch, event), a "{REVERSAL_LOSS}" of whirling orbits or a "{PERIOD_DOUBLING}" of unmirrored ones'
        raise ArrayError("start", getattr(event, "kind", event), "is nothing that such orbits begin at", remedy)
    if opens == PERIOD_DOUBLING:
        return (beyond_doubling(system, branch, event, p),)
    held = branch.closing.removesuffix(" held")
    value = held_value(system, p, held, branch.points[0])
    links, nx = system.links, system.nx
    x, omega = state_of_whirl(event.z), float(event.z[-1])
    link = int(np.argmax(np.abs(np.sin(event.z[:links]))))
    free = unknowns(links, link)
    z = np.concatenate([x, np.zeros(2 * links + 2), event.z[-2:]])[free]
    problem = unmirrored_problem(system, p, held=held, value=value, omega=omega, link=link)
    _, sizes, rows = np.linalg.svd(problem.at(z / problem.sizes).jacobian)
    if sizes[-1] > _SINGULAR * sizes[0]:
        raise UnsupportedError("start", REVERSAL_LOSS, "is where only one family passes", "start from another event")
    # The family that is left moves among states that the reversal keeps; the other goes straight away from them.
    null = np.zeros((8 * links + 4, 2))
    null[free] = rows[-2:].T * problem.sizes[:, None]
    even = read(fixed(event.z[:links], event.z[links : 2 * links]), null[:nx])[0]
    even[links:] /= omega
    kept = np.vstack([even, null[-2], null[-1] / omega])
    shape = null @ np.linalg.svd(kept)[2][-1]
    return (Lost.along(z, shape[free], links, held, value, link),)


def trace_unmirrored(system: System, lost: tuple[Lost, ...], mode: int, target: Target | None, run: Run) -> Branch:
    """Follow the orbits beyond a lost reversal, what their whirling family held being held.

    Args:
        system: A spatial chain on a fixed base.
        lost: Where they begin, `from_whirl`.
        mode: 1, there is one family.
        target: Where to end: omega or energy.
        run: How it is followed.

    Raises:
        ArrayError: These orbits have no such target.
        ConvergenceError: Newton did not reach the family.
    """
    if target is not None and target.what not in ("omega", "energy"):
        raise ArrayError("until", target.what, "is no quantity of orbits that do not start in a plane", 'use "omega=..." or "energy=..."')
    if run.earlier is None:
        begun = lost[mode - 1]
        held, value, link = begun.held, begun.value, begun.link
        problem = unmirrored_problem(system, run.p, held=held, value=value, omega=float(begun.z[-1]), link=link)
        first: Branch | Point = _first(problem, begun, run)
        name = f"{system.name}, {METHOD}, {held} held"
    else:
        held, value, link = read_closing(run.earlier.closing)
        first, problem, name = run.earlier, problem_of_branch(system, run.p, run.earlier), run.earlier.name
    tests = [*events_of(system, run.p, problem, held, link), *([target.level(system, problem, 0)] if target is not None else [])]
    tests.append(Level(lambda z: float(z[-1]), _SLOW * float(problem.sizes[-1]), "omega near zero"))
    branch = follow(problem, first, run.engine, tests, name, through=run.through, progress=run.progress)
    events, last = ended_by(branch, (BRANCH_POINT,))
    events += [replace(last, kind=_end_of(system, run.p, last.z, link))] if last else []
    reason = f"ended {events[-1].kind}" if last else branch.reason
    inertia = inertia_of(system, run.p)
    states = np.array([state_of_free(z, link) for z in branch.points])
    told = tuple(
        replace(event, breaks=_SAID.get(event.kind, ("", ""))[0], continues=_SAID.get(event.kind, ("", ""))[1], state=state_of_free(event.z, link))
        for event in events if genuine(event)
    )  # fmt: skip
    return replace(
        branch, events=told, reason=reason, states=states, momentum=np.array([momentum(inertia, x) for x in states]),
        closing=closing_of(held, value, link),
    )  # fmt: skip


def _first(problem: Problem, begun: Lost, run: Run) -> Point:
    """The first point, closer to where the family begins where Newton does not reach it from farther off.

    Raises:
        ConvergenceError: It reaches none.
    """
    normal = begun.shape / problem.sizes
    for share in _CLOSER:
        try:
            return start_on(problem, begun.z + share * run.amplitude_start * begun.shape, normal, run.engine, fixed=True)
        except ConvergenceError as failure:
            last = failure
    raise last


def events_of(system: System, p: Parameters | None, problem: Problem, held: str, link: int) -> list[TestFunction]:
    """The test functions of such a family."""
    count = system.nx - 2

    def turns(column: int) -> TestFunction:
        def along(point: Point) -> float:
            found: FreeMap = point.extra.found
            return float(found.slopes[:, column] @ point.slope(problem)[:count])

        return Quantity(along, ("energy extremum", "momentum extremum")[column])

    return [
        Fold(name="fold omega"),
        *([Fold(-2, "fold turn")] if held != "turn" else []),
        *([turns(0)] if held != "energy" else []),
        *([turns(1)] if held != "momentum" else []),
        BranchPoint(BRANCH_POINT, ends=lambda problem, point: _end_of(system, p, point.z(problem), link) != ""),
        Quantity(lambda point: float(np.prod(1 + point.multipliers).real), PERIOD_DOUBLING),
        Quantity(discriminant, "krein", in_pairs=True),
        too_unstable(),
    ]


def _end_of(system: System, p: Parameters | None, z: Vector, link: int) -> str:
    """Where a family ends at an orbit that has more symmetry: a mirror image that runs backwards, or half of the period; empty where it goes on."""
    if twice(system, p, z, link) < _SAME:
        return HALVED
    return REGAINED if mirrored(system, p, state_of_free(z, link), float(z[-1])) < _SAME else ""


def mirrored(system: System, p: Parameters | None, x: Vector, omega: float) -> float:
    """How far an orbit stays away from states that a reversal keeps: links in a vertical plane, moving across it; least on its way.

    Args:
        system: The chain.
        p: Runtime parameters.
        x: A state of the orbit (6 N,).
        omega: Its frequency, rad/s.
    """
    period = 2 * np.pi / omega
    times = np.linspace(0.0, period, _SAMPLES + 1)[1:]
    least = np.inf
    for _ in range(4):
        found = system.propagate(x[: system.nq], x[system.nq :], 0.0, float(times[-1]), 1e-16, times=times, **system.parameters(p))
        sizes = [_off(q, v * period / (2 * np.pi)) for q, v in zip(found.q_at, found.v_at, strict=True)]
        k = int(np.argmin(sizes))
        least = min(least, sizes[k])
        times = np.linspace(times[max(k - 1, 0)], times[min(k + 1, len(times) - 1)], 24)
        if times[0] <= 0:
            break
    return least


def _off(q: Vector, v: Vector) -> float:
    """What directions and rates of the links have across the vertical plane that fits them best."""
    links = len(q) // 3
    flat = np.vstack([q.reshape(links, 3)[:, :2], v.reshape(links, 3)[:, :2]])
    return float(np.linalg.svd(flat, compute_uv=False)[-1])
