"""A frequency response by harmonic balance: as many harmonics as the tail of the spectrum asks for, raised on the way."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np

from phichain.continuation import Branch, Engine, Point, Problem, follow, start_on
from phichain.continuation.core import Progress
from phichain.errors import ConvergenceError, UnsupportedError
from phichain.orbits.forced.floquet import tests_of
from phichain.orbits.forced.forcing import Forcing
from phichain.orbits.forced.made import ends_of, response_of
from phichain.orbits.forced.response import Response
from phichain.orbits.forced.series import NEEDED, coefficients_of, forced_problem
from phichain.orbits.harmonics.basis import Basis, basis, resized, tail
from phichain.orbits.harmonics.condensed import Harmonics
from phichain.system import Parameters, System, Vector

USUAL: Final = Harmonics(tail=1e-10, most=63)
"""Nothing is condensed here: a point costs the cube of all coefficients."""
UNRESOLVED: Final = "tail of the spectrum"
_SMALLEST: Final = 1e-3
"""Share of the amplitude by which the start is reached at least."""


@dataclass(frozen=True)
class _Unresolved:
    """The tail of the spectrum grows beyond what is wanted."""

    wanted: Harmonics
    basis: Basis
    name: str = UNRESOLVED
    terminal: bool = True

    def value(self, problem: Problem, point: Point) -> float:
        """Decades between the tail and what is wanted."""
        return float(np.log10(max(self.of(point.z(problem)), 1e-300) / self.wanted.tail))

    def of(self, z: Vector) -> float:
        """The tail of a solution."""
        return tail(z[:-1].reshape(self.basis.size, -1), self.basis.order)


def followed(
    system: System, forcing: Forcing, ends: tuple[float, float], p: Parameters | None, wanted: Harmonics, engine: Engine,
    progress: Progress | None,
) -> Response:  # fmt: skip
    """The response between two frequencies.

    Raises:
        UnsupportedError: The system lacks what the balance needs.
        ConvergenceError: Newton did not reach a solution at the first frequency.
    """
    absent = [name for name in NEEDED if not system.has(name)]
    if absent or system.real != "double":
        lacks = f"the function {absent[0]}" if absent else 'double precision, [target] real = "double"'
        raise UnsupportedError(
            "method", "harmonics", f"system '{system.name}' lacks {lacks}", f"build its scene with [functions] want = {list(NEEDED)}"
        )
    kind = "odd" if forcing.is_odd else "full"
    table = basis(kind, _fits(kind, wanted.least))
    z = _begun(system, forcing, table, p, ends, engine)
    while (left := tail(coefficients_of(z, system.nq), table.order)) > wanted.tail and table.highest < wanted.most:
        table = basis(kind, _fits(kind, wanted.above(table.highest, left)))
        z = _solved(system, forcing, table, p, ends, engine, _resized(z, table, system.nq))
    if left > wanted.tail:
        raise ConvergenceError(
            "harmonics", wanted.most, f"leave a tail of {left:.2g} at the first frequency, above {wanted.tail:g}",
            "allow more, a longer tail, a smaller amplitude, or use method = \"shooting\"",
        )  # fmt: skip
    problem = _problem(system, forcing, table, p, ends)
    start: Any = start_on(problem, z, _towards(z, ends), engine, fixed=True)
    while True:
        tests = [*tests_of(system, forcing.is_odd), _Unresolved(wanted, table), *ends_of(ends)]
        branch = follow(problem, start, engine, tests, "response", progress=progress)
        if branch.status != "event" or branch.events[-1].kind != UNRESOLVED:
            break
        if table.highest >= wanted.most:
            last = branch.events[-1].z
            why = f"the harmonics up to {wanted.most} leave a tail above {wanted.tail:g} from omega = {last[-1]:.6g} on: shooting would go on"
            branch = replace(branch, reason=why)
            break
        table = basis(kind, _fits(kind, wanted.above(table.highest, wanted.tail * 10)))
        start, problem = _longer(branch, system, table), _problem(system, forcing, table, p, ends)
    return response_of(system, forcing, branch, "harmonics", [coefficients_of(z, system.nq) for z in branch.points], table)


def _fits(kind: str, highest: int) -> int:
    """Odd where only odd harmonics are kept."""
    return highest | 1 if kind == "odd" else highest


def _problem(system: System, forcing: Forcing, table: Basis, p: Parameters | None, ends: tuple[float, float]) -> Problem:
    problem = forced_problem(system, forcing, table, p, omega=max(ends))
    return replace(problem, error=lambda point: tail(coefficients_of(point.z(problem), system.nq), table.order))


def _towards(z: Vector, ends: tuple[float, float]) -> Vector:
    """Along omega, from the first frequency to the second."""
    direction = np.zeros(len(z))
    direction[-1] = np.sign(ends[1] - ends[0])
    return direction


def _resized(z: Vector, table: Basis, n: int) -> Vector:
    return np.append(resized(coefficients_of(z, n), table.size).ravel(), z[-1])


def _solved(
    system: System, forcing: Forcing, table: Basis, p: Parameters | None, ends: tuple[float, float], engine: Engine, z: Vector
) -> Vector:
    """Newton at the first frequency."""
    problem = _problem(system, forcing, table, p, ends)
    return start_on(problem, z, _towards(z, ends), engine, fixed=True).z(problem)


def _begun(
    system: System, forcing: Forcing, table: Basis, p: Parameters | None, ends: tuple[float, float], engine: Engine
) -> Vector:
    """A solution at the first frequency, reached through smaller amplitudes where Newton does not reach it at once.

    Raises:
        ConvergenceError: Not even through small steps.
    """
    z, reached, share = np.append(np.zeros(table.size * system.nq), ends[0]), 0.0, 1.0
    while True:
        aim = min(1.0, reached + share)
        try:
            z = _solved(system, replace(forcing, amplitude=aim * forcing.amplitude), table, p, ends, engine, z)
        except ConvergenceError as failure:
            share /= 2
            if share < _SMALLEST:
                raise ConvergenceError(
                    "omega", ends[0], f"has no periodic motion that Newton reaches ({failure.problem})",
                    "start at a frequency farther from resonance, or with a smaller amplitude",
                ) from failure  # fmt: skip
            continue
        if aim == 1.0:
            return z
        reached, share = aim, 2 * share


def _longer(branch: Branch, system: System, table: Basis) -> Branch:
    """The same points with more harmonics, which are zero: a place to go on from."""
    n = system.nq
    problem_names = branch.names

    def widened(rows: Vector) -> Vector:
        return np.array([_resized(row, table, n) for row in rows])

    events = tuple(replace(event, z=_resized(event.z, table, n)) for event in branch.events)
    passages = tuple(replace(gap, z=_resized(gap.z, table, n)) for gap in branch.passages)
    scale = np.append(np.ones(table.size * n), branch.scale[-1])
    return replace(
        branch, names=problem_names, points=widened(branch.points), tangent=widened(branch.tangent), scale=scale, events=events,
        passages=passages,
    )  # fmt: skip
