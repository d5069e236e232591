"""What is held while a parameter is turned: a quantity of the orbit, or that it is an event of its family.

Each is a scalar h(z; lambda) that stays what it was. Events of a family are zeros of smooth functions, those that the family itself is looked
through for; where a function is of the family's tangent t, which the orbit alone has but for its sign, t is turned so that det [J; t] > 0.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from phichain.continuation import BranchPoint, Evaluation, Fold, Point, Problem, Quantity, TestFunction
from phichain.continuation.linear import bordered, sign_of_determinant
from phichain.continuation.point import tangent_of
from phichain.errors import ArrayError
from phichain.orbits.parameter.followed import Followed
from phichain.system import Vector

_COVER: Final = re.compile(r"cover (\d+)\b")
_TANGENTIAL: Final = ("energy extremum", "momentum extremum")
"""Functions of the family's tangent, besides folds."""
Scalar = Callable[[Problem, Vector, Evaluation], float]
"""The problem, an orbit z, and what is known there -> h."""


@dataclass(frozen=True)
class Held:
    """A quantity or an event.

    Attributes:
        what: its name.
        scalar: h where it is no unknown; None where it is.
        unknown: which of the unknowns it is; None where it is none of them.
        is_event: whether it is zero on what is followed, so that its value is no matter.
    """

    what: str
    scalar: Scalar | None = None
    unknown: int | None = None
    is_event: bool = False

    def at(self, problem: Problem, z: Vector) -> float:
        """h of the orbit z."""
        if self.unknown is not None:
            return float(z[self.unknown])
        assert self.scalar is not None
        return self.scalar(problem, z, problem.evaluate(z))


def held_of(followed: Followed, problem: Problem, what: str, z: Vector) -> Held:
    """What a word says is held.

    Args:
        followed: the kind of orbits.
        problem: theirs at the first value of the parameter.
        what: "omega", "energy", an unknown's name such as "theta_2", "amplitude" (the angle that is largest at the start), or an event's kind, such
            as "fold omega", "brake loss" or "krein"; or "cover K of mode J", the orbit being the shorter one, of mode J.
        z: the orbit.

    Raises:
        ArrayError: it is none of these.
    """
    names = [name for name in problem.names if name != "unfolding"]
    links = [name for name in names if name.startswith("theta_") and name[6:].isdecimal()]
    unknowns = {name: problem.names.index(name) for name in names}
    if followed.angles:
        # Names of a scene's own count as theta_K, too.
        unknowns |= {f"theta_{k + 1}": at for k, at in enumerate(followed.angles)}
        unknowns["amplitude"] = followed.angles[int(np.argmax(np.abs(z[list(followed.angles)])))]
    if what in unknowns:
        return Held(what, unknown=unknowns[what])
    if what == "energy" and problem.energy is not None:
        return Held(what, lambda own, z, found: _energy(own, z))
    events = holdable(followed, problem)
    if what in events:
        return Held(what, _event(followed, problem, what, z), is_event=True)
    if (times := times_of(what)) and (len(links) > 1 or len(followed.angles) > 1):
        return Held(what, _turning_by(times), is_event=True)
    known = [*unknowns, *(["energy"] if problem.energy else []), *events, "cover K"]
    raise ArrayError("hold", what, "is nothing that can be held here", f"use {', '.join(dict.fromkeys(known))}")


def holdable(followed: Followed, problem: Problem) -> tuple[str, ...]:
    """The events of a kind of orbits that have a locus in two parameters."""
    return tuple(dict.fromkeys(test.name for test in followed.events(problem) if _has_locus(test)))


def beside(followed: Followed, problem: Problem, held: Held) -> list[TestFunction]:
    """The events of a kind that a run in a parameter may meet: those that the family's tangent does not tell, and that are not held."""
    return [
        replace(test, of=_of_orbit(test.of)) for test in followed.events(problem)
        if isinstance(test, Quantity) and test.ends is None and test.name not in (*_TANGENTIAL, held.what)
    ]  # fmt: skip


def _of_orbit(of: Callable[[Point], float]) -> Callable[[Point], float]:
    """A function of orbits at points that carry a parameter as well."""

    def shorter(point: Point) -> float:
        own = replace(point, y=point.y[:-1], tangent=point.tangent[:-1], jacobian=point.jacobian[:-1, :-1])
        return of(own)

    return shorter


def times_of(what: str) -> int:
    """K of "cover K ..."; 0 of anything else."""
    found = _COVER.match(what)
    return int(found[1]) if found else 0


def value_of(test: TestFunction, problem: Problem, z: Vector, found: Evaluation) -> float:
    """A test function of one orbit, the tangent of its family turned so that det [J; t] > 0."""
    y, jacobian = z / problem.sizes, found.jacobian * problem.sizes
    tangent = tangent_of(jacobian, np.ones(len(y)))
    if sign_of_determinant(bordered(jacobian, tangent)) < 0:
        tangent = -tangent
    return test.value(problem, Point(y, tangent, 0.0, jacobian, 0.0, 0, (), found.extra))


def _has_locus(test: TestFunction) -> bool:
    """Not a crossing of families, which another parameter opens into a gap, nor a mere end."""
    return isinstance(test, Fold) or (isinstance(test, Quantity) and not test.terminal and not isinstance(test, BranchPoint))


def _energy(problem: Problem, z: Vector) -> float:
    assert problem.energy is not None
    return problem.energy(z)


def _event(followed: Followed, problem: Problem, what: str, z: Vector) -> Scalar:
    """The function whose zero the event is; of several of one name that which is least at the orbit."""
    found = problem.evaluate(z)
    own = [(abs(value_of(test, problem, z, found)), k) for k, test in enumerate(followed.events(problem)) if test.name == what and _has_locus(test)]
    at = min(own)[1]
    return lambda problem, z, found: value_of(followed.events(problem)[at], problem, z, found)


def _turning_by(times: int) -> Scalar:
    """kappa = cos(pi j / K): traversed K times the orbit has lambda = 1 with both of its vectors, which is where the family that covers it crosses.

    j is even where kappa is of the whole period, or K is odd; which it is is looked up at the first orbit.
    """
    chosen: list[float] = []

    def off(problem: Problem, z: Vector, found: Evaluation) -> float:
        kappa = found.extra.multipliers.real
        if not chosen:
            turns = np.cos(np.pi * np.arange(1, times) / times)
            chosen.append(float(turns[np.argmin(np.min(np.abs(kappa[:, None] - turns), axis=0))]))
        return float(np.prod(kappa - chosen[0]))

    return off
