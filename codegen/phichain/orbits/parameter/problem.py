"""Brake orbits in a parameter: theta(T/4; q_0, lambda) = 0 and one held quantity as a continuation problem.

Unknowns are (q_0, omega, lambda). One propagation gives the residual and, with one column for lambda beside those of the angles,
its exact Jacobian. A held unknown has an exact row, too; the row of a held energy or event is differenced, which Newton's corrections
feel and the solution does not.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from phichain.continuation import Evaluation, Point, Problem
from phichain.continuation.problem import LateExtra, Multipliers
from phichain.orbits.parameter.held import Held
from phichain.orbits.parameter.knob import Knob
from phichain.orbits.quarter import EPS, QuarterMap, quarter_problem
from phichain.system import System, Vector

_STEPS = 20_000
_WIDTH = 1e-5
"""Share of an unknown's size over which a held scalar is differenced."""


def parameter_problem(
    system: System, p: dict[str, Any], knob: Knob, held: Held, start: Vector
) -> Problem:
    """The problem around an orbit.

    Args:
        system: a planar, undamped system whose flow carries derivatives by the parameter.
        p: all runtime parameters.
        knob: the one that is turned.
        held: what stays.
        start: (q_0, omega) of the orbit.
    """
    value = 0.0 if held.is_event else _held_value(system, p, held, start)
    nq, carts = system.nq, system.cart_size
    sizes = np.exp2(np.round(np.log2(np.where(start == 0, 1.0, np.abs(start)))))
    sizes[carts:nq] = 1.0
    size = abs(knob.of(p)) or 1.0

    def family(parameters: dict[str, Any]) -> Problem:
        return quarter_problem(system, parameters, omega=float(start[-1]), shape=np.ones(nq))

    def scalar(z: Vector, parameters: dict[str, Any]) -> float:
        if held.scalar is None:
            return _energy(system, parameters, z)
        return held.scalar(z, family(parameters).evaluate(z))

    def row(z: Vector, knob_value: float) -> tuple[float, Vector]:
        slope = np.zeros(nq + 2)
        if held.unknown is not None:
            slope[held.unknown] = 1.0
            return float(z[held.unknown]) - value, slope
        for i in range(nq + 2):
            h = _WIDTH * (size if i > nq else sizes[i])
            ends = []
            for sign in (1.0, -1.0):
                moved, turned = z.copy(), knob_value
                if i > nq:
                    turned += sign * h
                else:
                    moved[i] += sign * h
                ends.append(scalar(moved, knob.turned(p, turned)))
            slope[i] = (ends[0] - ends[1]) / (2 * h)
        return scalar(z, knob.turned(p, knob_value)) - value, slope

    def evaluate(whole: Vector) -> Evaluation:
        z, turned = whole[:-1], float(whole[-1])
        if not (z[-1] > 0 and np.all(np.isfinite(whole)) and knob.allows(turned)):
            return Evaluation(np.full(nq + 1, np.nan), np.full((nq + 1, nq + 2), np.nan))
        parameters = knob.turned(p, turned)
        residual, jacobian, steps = _quarter(system, parameters, knob, z)
        if np.all(np.isfinite(residual)):
            last, slope = row(z, turned)
            residual, jacobian = np.append(residual, last), np.vstack([jacobian, slope])
        else:
            residual, jacobian = np.append(residual, np.nan), np.vstack([jacobian, np.full(nq + 2, np.nan)])

        def blocks() -> tuple[Multipliers, QuarterMap]:
            extra = family(parameters).evaluate(z).extra
            noise = np.abs(jacobian) @ np.abs(whole) * (EPS * (1 + steps))
            return extra.multipliers, replace(extra.found, noise=noise)

        return Evaluation(residual, jacobian, LateExtra(blocks))

    return Problem(
        evaluate=evaluate,
        names=(*(system.q_names or tuple(f"q_{k + 1}" for k in range(nq))), "omega", str(knob)),
        scale=np.append(sizes, np.exp2(np.round(np.log2(size)))),
        energy=(lambda whole: _energy(system, knob.turned(p, float(whole[-1])), whole[:-1])) if system.has("energy") else None,
        error=_error,
    )


def _quarter(system: System, parameters: dict[str, Any], knob: Knob, z: Vector) -> tuple[Vector, Vector, int]:
    """q(T/4), its derivatives by (q_0, omega, lambda), and the steps it took; not finite where it cannot be followed."""
    nq, carts, links = system.nq, system.cart_size, system.links
    quarter = np.pi / (2 * float(z[-1]))
    columns = np.zeros((2 * nq, links + 1))
    columns[carts:nq, :links] = np.eye(links)
    found = system.propagate(
        z[:-1], np.zeros(nq), 0.0, quarter, EPS, max_steps=_STEPS, transition=columns, along=knob.direction(links + 1, links),
        **system.parameters(parameters),
    )  # fmt: skip
    if found.outcome != "done":
        return np.full(nq, np.nan), np.full((nq, nq + 2), np.nan), 0
    jacobian = np.zeros((nq, nq + 2))
    jacobian[:carts, :carts] = 1.0
    jacobian[:, carts:nq] = found.transition[:nq, :links]
    jacobian[:, nq] = found.v * (-quarter / float(z[-1]))
    jacobian[:, nq + 1] = found.transition[:nq, links]
    return found.q, jacobian, found.steps


def _energy(system: System, parameters: dict[str, Any], z: Vector) -> float:
    """V(q_0), counted from the hanging rest, J."""
    still, given = np.zeros(system.nv), system.parameters(parameters)
    ends = (float(system.energy(q, still, **given)[1]) for q in (z[:-1], np.zeros(system.nq)))
    return next(ends) - next(ends)


def _held_value(system: System, p: dict[str, Any], held: Held, start: Vector) -> float:
    return _energy(system, p, start) if held.unknown is None else float(start[held.unknown])


def _error(point: Point) -> float:
    """How far off the parameter may be, relative to its size: what rounding left in the residual, through [J; t]^-1."""
    try:
        inverse = np.linalg.inv(np.vstack([point.jacobian, point.tangent]))
    except np.linalg.LinAlgError:
        return float("nan")
    return float(np.abs(inverse[-1, :-1]) @ point.extra.found.noise / max(abs(point.y[-1]), EPS))
