"""Starting from any orbit: its state and period as they are given, closed by Newton, and put under the kind
that its symmetries say."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, Final

import numpy as np

from phichain.continuation import Branch, Options, Point, Problem, correctors
from phichain.continuation.point import tangent_of
from phichain.errors import ArrayError, ConvergenceError
from phichain.orbits.closed.kinds import problem_of, state_of, unknowns_of
from phichain.orbits.closed.symmetries import recognised, taken_up
from phichain.orbits.targets import Target, placed, point_index
from phichain.system import Parameters, System, Vector
from phichain.system.arrays import positive, reals
from phichain.system.starts import numbers

_REMEDY: Final = 'give a Branch, a point of its file, {"q": ..., "v": ..., "period": ...}, or "FILE.json:POINT"'
_CLOSING: Final = Options(tol=1e-9, max_iterations=25)
_FAR: Final = 0.5
"""How far Newton may move a start, in its size: what is farther is another orbit than the one that was
given."""


def given(system: System, start: Any) -> tuple[Vector, Vector, float]:
    """q, v (nq,) and omega of an orbit as it was given.

    Args:
        system: The chain.
        start: A Branch (its last point), (Branch, index), "FILE.json" or "FILE.json:INDEX" of one, a text
            like "q=1,0.4; v=0,0; period=1.7", or a mapping or record with q, v and period or omega, as a
            point of a family's file has them.

    Raises:
        ArrayError: It is none of these, or does not fit the chain.
        OutputError: The file holds no Branch.
    """
    if isinstance(start, Path | str):
        start = _read(str(start))
    if isinstance(start, Branch):
        start = (start, -1)
    if isinstance(start, tuple) and len(start) == 2 and isinstance(start[0], Branch):
        return _of_branch(system, *start)
    if isinstance(start, Mapping):
        fields = {**start, **start["start"]} if isinstance(start.get("start"), Mapping) else dict(start)
    else:
        fields = {name: getattr(start, name) for name in ("q", "v", "omega", "period") if hasattr(start, name)}
    if "q" not in fields or not {"omega", "period"} & fields.keys():
        raise ArrayError("start", start, "is no orbit: it needs q and a period (or omega)", _REMEDY)
    q, v = (np.array(reals(f"start.{name}", fields.get(name, np.zeros(system.nq)), _REMEDY)) for name in "qv")
    # A record of an orbit holds samples over its period.
    q, v = (part[0] if part.ndim == 2 and len(part) else part for part in (q, v))
    for name, part in (("q", q), ("v", v)):
        if part.shape != (system.nq,) or not np.all(np.isfinite(part)):
            raise ArrayError(f"start.{name}", part.tolist(), f"must hold {system.nq} finite numbers", _REMEDY)
    if "omega" in fields:
        return q, v, positive("start.omega", fields["omega"], "give rad/s", ArrayError)
    return q, v, 2 * np.pi / positive("start.period", fields["period"], "give seconds", ArrayError)


def _read(text: str) -> Any:
    if "=" in text:
        parts = [part.partition("=") for part in text.split(";")]
        found = {name.strip(): numbers(values, f"start.{name.strip()}") for name, _, values in parts}
        return {name: value if name in "qv" or value is None or value.size != 1 else float(value[0]) for name, value in found.items()}
    path, place = placed(text)
    return (Branch.from_json(path), point_index(place)) if place else Branch.from_json(path)


def _of_branch(system: System, branch: Branch, index: Any) -> tuple[Vector, Vector, float]:
    if branch.digest != system.digest:
        raise ArrayError("start", branch.digest, f"is the digest of that branch's scene, and {system.digest!r} is wanted here", "use its scene")
    # Series over a period are brake orbits, as shooting over a quarter of it has them.
    closing = branch.closing or ("quarter" if branch.method == "harmonics" else "")
    if not closing or branch.names[-1] != "omega":
        raise ArrayError(
            "start", branch.method, "is how that branch was traced: its points are no orbits of the whole equations of one chain", 'trace it with method = "shooting"'
        )
    if not isinstance(index, int) or not -len(branch) <= index < len(branch):
        raise ArrayError("start", index, f"is no point of that branch, which has {len(branch)}", f"use 0 .. {len(branch) - 1}; in FILE.json:POINT they count from 1")
    z = branch.points[index]
    return *state_of(closing, z), float(z[-1])


def closed(system: System, p: Parameters | None, q: Vector, v: Vector, omega: float) -> tuple[str, Problem, Point]:
    """The orbit nearest to a state and a frequency, under its kind.

    Returns:
        The kind, its problem, and the orbit as a point of it, its energy rising along the tangent.

    Raises:
        ConvergenceError: Newton closed no orbit nearby.
        ArrayError: The chain hangs still there.
    """
    if not max(np.max(np.abs(q[system.cart_size :])), np.max(np.abs(v)) / omega) > 0:
        raise ArrayError("start", q.tolist(), "hangs still, which is no orbit", "start from a linear mode: trace(system, mode=1)")
    kind, z = _first_guess(system, p, q, v, omega)
    own, times = recognised(system, p, *state_of(kind, z), float(z[-1]))
    if (own, times) != (kind, 1):
        at = taken_up(system, p, own, *state_of(kind, z), times * float(z[-1]))
        kind, z = own, unknowns_of(own, *at, times * float(z[-1]))
    problem = problem_of(system, p, kind, z)
    return kind, problem, _point(problem, z)


def _first_guess(system: System, p: Parameters | None, q: Vector, v: Vector, omega: float) -> tuple[str, Vector]:
    """An orbit nearby under the first kind that closes it: between two rests, or as a brake orbit, where it
    starts at one, else without any symmetry."""
    kinds = ("unequal", "quarter", "whole") if not np.any(v) else ("whole",)
    failure: ConvergenceError | None = None
    for kind in kinds:
        state = (q, v) if kind != "whole" else taken_up(system, p, kind, q, v, omega)
        z = unknowns_of(kind, *state, omega)
        problem = problem_of(system, p, kind, z)
        try:
            return kind, _point(problem, z).z(problem)
        except ConvergenceError as said:
            failure = said
    assert failure is not None
    raise failure


def _point(problem: Problem, z: Vector) -> Point:
    """The nearest orbit, by Gauss and Newton.

    Raises:
        ConvergenceError: There is none nearby.
    """
    guess = problem.check(z) / problem.sizes
    found = correctors.moore_penrose(problem, guess, np.zeros_like(guess), _CLOSING)
    far = float(np.linalg.norm(found.y - guess)) > _FAR * float(np.linalg.norm(guess[:-1]))
    if not found.converged or far:
        where = "went to another orbit far away" if found.converged else f"did not close the orbit in {found.iterations} iterations"
        raise ConvergenceError(
            "start", z.tolist(), f"Newton {where} (relative residual {found.residual:.2g})",
            "give a state and a period that come back more nearly, or start from a linear mode and trace until there",
            corrections=found.corrections,
        )  # fmt: skip
    assert problem.energy is not None
    along = tangent_of(found.jacobian, np.eye(len(guess))[-1])
    step = 1e-5 * along
    rises = problem.energy((found.y + step) * problem.sizes) > problem.energy((found.y - step) * problem.sizes)
    return found.point(along if rises else -along, 0.0)


def towards(system: System, problem: Problem, point: Point, target: Target | None) -> Point:
    """The point turned so that what is to reach a value goes there."""
    if target is None:
        return point
    level = target.level(system, problem)
    z, step = point.z(problem), 1e-5 * point.slope(problem)
    change = level.scalar(z + step) - level.scalar(z - step)
    return replace(point, tangent=-point.tangent) if change * (level.level - level.scalar(z)) < 0 else point

