"""What is turned with a parameter: orbits of one kind as a problem at any value of it, and how the equations change with that.

Of planar orbits the change of the residual comes from the flow, as one more column of derivatives. Relative equilibria have no flow, and spatial
orbits close by what the parameter changes too: there it is taken by differences to the fourth order, which Newton's corrections feel to twelve
digits and the solution does not.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np

from phichain.continuation import Problem, TestFunction
from phichain.errors import UnsupportedError
from phichain.orbits import in_plane, shooting
from phichain.orbits.closed.kinds import events_of, problem_of, state_of
from phichain.orbits.conical.families import events_of as conical_events
from phichain.orbits.conical.problem import conical_problem
from phichain.orbits.conical.starts import METHOD as CONICAL
from phichain.orbits.conical.turning import turning
from phichain.orbits.forced.floquet import tests_of as forced_events
from phichain.orbits.forced.flow import EmittedFlow
from phichain.orbits.forced.forcing import Forcing
from phichain.orbits.forced.shot import shooting_problem
from phichain.orbits.in_space.family import events_of as space_events
from phichain.orbits.in_space.problem import METHOD as IN_SPACE
from phichain.orbits.in_space.problem import kept_of, pairs_of, space_problem, state_at_rest
from phichain.orbits.modes import demand_oscillations
from phichain.orbits.parameter.knob import Knob
from phichain.orbits.periodic import least_potential
from phichain.orbits.quarter import EPS
from phichain.orbits.unmirrored.family import events_of as unmirrored_events
from phichain.orbits.unmirrored.problem import METHOD as UNMIRRORED
from phichain.orbits.unmirrored.problem import read_closing, state_of_free, unmirrored_problem
from phichain.orbits.whirling.families import events_of as whirling_events
from phichain.orbits.whirling.problem import state_of_whirl, whirling_problem
from phichain.orbits.whirling.starts import METHOD as WHIRLING
from phichain.system import System, Vector

FORCED: Final = "forced"
AMPLITUDE: Final = "amplitude"
"""Name of the forcing's amplitude among the parameters of driven orbits."""
_SHARE: Final = {"quarter": 0.25, "unequal": 0.5, "odd": 0.5, "half": 0.5, "whole": 1.0}
"""Which part of the period closes a kind."""
_STEPS: Final = 40_000
_BESIDE: Final = 2.0**-9
"""Share of a parameter over which the residual is differenced: its fourth power and rounding over it are some 1e-12."""
Values = dict[str, Any]


@dataclass(frozen=True)
class Followed:
    """One kind of orbits of a chain.

    Attributes:
        kind: "quarter", "unequal", "odd", "half", "whole", "forced", or a method of spatial orbits; and how their family is closed besides.
        family: Parameters -> the problem there; unknowns and their sizes stay.
        by_parameter: (z, parameters, knob) -> dF/dlambda (n,).
        events: A problem -> the test functions of a family of that kind.
        state: z -> (q, v) at the start (nx,).
        angles: Which unknowns are angles of the start's rest.
    """

    kind: str
    family: Callable[[Values], Problem]
    by_parameter: Callable[[Vector, Values, Knob], Vector]
    events: Callable[[Problem], list[TestFunction]]
    state: Callable[[Vector], Vector]
    angles: range = range(0)


@dataclass(frozen=True)
class _Made:
    """What a method says of its orbits, as in `Followed`."""

    family: Callable[[Values], Problem]
    events: Callable[[Problem], list[TestFunction]]
    state: Callable[[Vector], Vector]


def differenced(value: Callable[[float], Vector], at: float, allows: Callable[[float], bool]) -> Vector:
    """d value / d lambda to the fourth order; from one side where a chain has no smaller value."""
    h = _BESIDE * (abs(at) or 1.0)
    if allows(at - 2 * h):
        one, two = (value(at + k * h) - value(at - k * h) for k in (1, 2))
        return np.asarray((8 * one - two) / (12 * h))
    places = [value(at + k * h) for k in range(5)]
    return np.asarray(np.tensordot([-25.0, 48.0, -36.0, 16.0, -3.0], places, 1) / (12 * h))


def closed_orbits(system: System, kind: str, z: Vector, values: Values) -> Followed:
    """Planar orbits of one of `closed.kinds`, sized by one of them, z.

    Raises:
        UnsupportedError: The chain has none, or lacks what shooting needs.
    """
    demand_oscillations(system)
    shooting.demand_shooting(system, shooting.NEEDED if kind == "quarter" else (*shooting.NEEDED, "forward_dynamics"))
    sizes = problem_of(system, values, kind, z).sizes
    nq, carts = system.nq, system.cart_size

    def family(parameters: Values) -> Problem:
        return replace(problem_of(system, parameters, kind, z), scale=sizes)

    def by_parameter(z: Vector, parameters: Values, knob: Knob) -> Vector:
        q, v = state_of(kind, z)
        column = _carried(system, q, v, _SHARE[kind] * 2 * np.pi / float(z[-1]), parameters, knob)
        if kind in ("quarter", "odd"):
            return column[:nq]
        if kind == "unequal":
            return column[np.r_[0:carts, nq + carts : 2 * nq]]
        x = z[: 2 * nq]
        turns = differenced(
            lambda value: np.array(least_potential(system, knob.turned(parameters, value))(x)[0]), knob.of(parameters), knob.allows
        )
        if kind == "whole":
            # Where the cart is has its own row.
            column[nq : nq + carts] = 0.0
        return np.append(column, turns)

    return Followed(
        kind, family, by_parameter, lambda problem: events_of(system, values, kind, problem),
        lambda z: np.concatenate(state_of(kind, z)), range(carts, nq) if kind in ("quarter", "unequal") else range(0),
    )  # fmt: skip


def driven_orbits(system: System, forcing: Forcing, periods: int, z: Vector, values: Values) -> Followed:
    """Motions under A cos(omega t) that come back after so many of its periods.

    Raises:
        UnsupportedError: The system has no flow that is forced there.
    """
    over = periods if periods > 1 else None
    is_odd = forcing.is_odd and over is None
    share = 0.5 if is_odd else float(periods)
    nq = system.nq

    def family(parameters: Values) -> Problem:
        own = replace(forcing, amplitude=float(parameters[AMPLITUDE]))
        return shooting_problem(system, own, EmittedFlow(system, own, of_chain(parameters)), omega=float(z[-1]), periods=over)

    def by_parameter(z: Vector, parameters: Values, knob: Knob) -> Vector:
        span = share * 2 * np.pi / float(z[-1])
        if knob.name in system.varied:
            return _carried(system, z[:nq], z[nq:-1], span, of_chain(parameters), knob, (float(parameters[AMPLITUDE]), float(z[-1])))
        return differenced(lambda value: family(knob.turned(parameters, value)).evaluate(z).residual, knob.of(parameters), knob.allows)

    family(values)
    return Followed(f"{FORCED}, {periods}, {float(values[AMPLITUDE])!r}", family, by_parameter, lambda problem: forced_events(system, is_odd), lambda z: z[:-1])


def spatial_orbits(system: System, method: str, z: Vector, values: Values, more: str = "") -> Followed:
    """Orbits of a spatial chain by the method that traces them.

    Args:
        system: The chain.
        method: "conical", "in a plane", "in space", "whirling" or "unmirrored".
        z: One of the orbits: their size.
        values: All parameters.
        more: How their family is closed besides, as its Branch says: "momentum held at 0.3", "in the plane link 2", or both of "unmirrored".

    Raises:
        UnsupportedError: The chain has none, or lacks what they need.
    """
    omega, links = float(z[-1]), system.links
    first, count = (int(system.has_cart), links) if method == CONICAL else (0, 0 if method == UNMIRRORED else links)
    if method == CONICAL:
        made = _Made(
            lambda parameters: conical_problem(system, parameters, omega=omega), lambda problem: conical_events(system, problem),
            lambda z: turning(system, z).x,
        )  # fmt: skip
    elif method == in_plane.METHOD:
        made = _Made(
            lambda parameters: in_plane.plane_problem(system, parameters, omega=omega), lambda problem: in_plane.events_of(system, problem),
            lambda z: in_plane.at_rest(system, z).x,
        )  # fmt: skip
    elif method == IN_SPACE:
        kept = kept_of(more)
        made = _Made(
            lambda parameters: space_problem(system, parameters, omega=omega, kept=kept), lambda problem: space_events(system, problem, kept),
            lambda z: np.append(state_at_rest(links, pairs_of(z, kept)), np.zeros(system.nv)),
        )  # fmt: skip
    elif method == WHIRLING:
        held, _, number = more.partition(" held at ")
        made = _Made(
            lambda parameters: whirling_problem(system, parameters, held=held, value=float(number), omega=omega),
            lambda problem: whirling_events(system, problem, held), state_of_whirl,
        )  # fmt: skip
    else:
        what, value, link = read_closing(more)
        made = _Made(
            lambda parameters: unmirrored_problem(system, parameters, held=what, value=value, omega=omega, link=link),
            lambda problem: unmirrored_events(system, values, problem, what, link), lambda z: state_of_free(z, link),
        )  # fmt: skip

    def by_parameter(z: Vector, parameters: Values, knob: Knob) -> Vector:
        return differenced(lambda value: made.family(knob.turned(parameters, value)).evaluate(z).residual, knob.of(parameters), knob.allows)

    kind = f"{method}, {more}" if more else method
    return Followed(kind, made.family, by_parameter, made.events, made.state, range(first, first + count))


def of_chain(parameters: Values) -> Values:
    """Parameters without the forcing's amplitude, which is none of the chain's."""
    return {name: value for name, value in parameters.items() if name != AMPLITUDE}


def _carried(
    system: System, q: Vector, v: Vector, span: float, parameters: Values, knob: Knob, forcing: tuple[float, float] | None = None
) -> Vector:
    """The derivative (2 nq,) of where a motion ends by the parameter; not finite where it cannot be followed.

    Raises:
        UnsupportedError: The flow carries no derivatives by it.
    """
    if knob.name not in system.varied:
        raise UnsupportedError(
            "parameter", str(knob), f"is none that the flow of '{system.name}' carries derivatives by",
            f'set it to "runtime" in the scene and name it there: [flow] variational = ["state", "{knob.name}"]',
        )  # fmt: skip
    driven = {} if forcing is None else {"forcing": forcing}
    found = system.propagate(
        q, v, 0.0, span, EPS, max_steps=_STEPS, transition=np.zeros((2 * system.nq, 1)), along=knob.direction(1, 0), **driven,
        **system.parameters(parameters),
    )  # fmt: skip
    if found.outcome != "done":
        return np.full(2 * system.nq, np.nan)
    return np.array(found.transition[:, 0])
