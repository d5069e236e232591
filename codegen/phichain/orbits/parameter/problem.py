"""Orbits in a parameter: F(z; lambda) = 0 of their kind and one held quantity h(z; lambda) = h_0 as a continuation problem.

Unknowns are (z, lambda). A held unknown has an exact row in the Jacobian; the row of a held energy or event is differenced, which Newton's
corrections feel and the solution does not.
"""

from __future__ import annotations

import numpy as np

from phichain.continuation import Evaluation, Point, Problem
from phichain.orbits.parameter.followed import Followed, Values
from phichain.orbits.parameter.held import Held
from phichain.orbits.parameter.knob import Knob
from phichain.orbits.quarter import EPS, powers
from phichain.system import Vector

_WIDTH = 2e-6
"""Share of an unknown's size over which a held scalar is differenced, to the fourth order: where two multipliers meet it bends sharply."""


def parameter_problem(followed: Followed, values: Values, knob: Knob, held: Held, value: float) -> Problem:
    """The problem around an orbit.

    Args:
        followed: the kind of orbits.
        values: all runtime parameters.
        knob: the one that is turned.
        held: what stays.
        value: h_0.
    """
    own = followed.family(values)
    size = float(powers(np.array([abs(knob.of(values)) or 1.0]))[0])
    scale = np.append(own.sizes, size)
    count = len(scale)

    def family(turned: float) -> Problem:
        return followed.family(knob.turned(values, turned))

    def scalar(whole: Vector) -> float:
        return held.at(family(float(whole[-1])), whole[:-1])

    def row(whole: Vector, problem: Problem, found: Evaluation) -> tuple[float, Vector]:
        slope = np.zeros(count)
        if held.unknown is not None:
            slope[held.unknown] = 1.0
            return float(whole[held.unknown]) - value, slope
        assert held.scalar is not None
        for i, h in enumerate(_WIDTH * scale):
            beside = h * np.eye(count)[i]
            one, two = (scalar(whole + k * beside) - scalar(whole - k * beside) for k in (1, 2))
            slope[i] = (8 * one - two) / (12 * h)
        return held.scalar(problem, whole[:-1], found) - value, slope

    def evaluate(whole: Vector) -> Evaluation:
        z, turned = whole[:-1], float(whole[-1])
        nothing = Evaluation(np.full(count - 1, np.nan), np.full((count - 1, count), np.nan))
        if not (np.all(np.isfinite(whole)) and z[-1] > 0 and knob.allows(turned)):
            return nothing
        problem = family(turned)
        found = problem.evaluate(z)
        if not np.all(np.isfinite(found.residual)):
            return nothing
        by_parameter = followed.by_parameter(z, knob.turned(values, turned), knob)
        last, slope = row(whole, problem, found)
        jacobian = np.vstack([np.column_stack([found.jacobian, by_parameter]), slope])
        return Evaluation(np.append(found.residual, last), jacobian, found.extra)

    def energy(whole: Vector) -> float:
        of = family(float(whole[-1])).energy
        assert of is not None
        return of(whole[:-1])

    return Problem(
        evaluate=evaluate, names=(*own.names, str(knob)), scale=scale, energy=None if own.energy is None else energy, error=_error,
    )  # fmt: skip


def _error(point: Point) -> float:
    """How far off omega and the parameter may be, relative to their sizes: what rounding left in the residual, through [J; t]^-1."""
    try:
        inverse = np.linalg.inv(np.vstack([point.jacobian, point.tangent]))
    except np.linalg.LinAlgError:
        return float("nan")
    # Of a propagation the noise is known; of everything else it is that of one rounding.
    noise = np.abs(point.jacobian) @ np.abs(point.y) * EPS
    own = getattr(point.extra.found, "noise", np.empty(0))
    noise[: len(own)] = own
    return float(np.max(np.abs(inverse[-2:, :-1]) @ noise / np.maximum(np.abs(point.y[-2:]), EPS)))
