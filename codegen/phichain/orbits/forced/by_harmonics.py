"""A frequency response by harmonic balance."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from phichain.continuation import Branch, Engine, Point, Problem, follow, start_on
from phichain.continuation.core import Progress
from phichain.errors import ConvergenceError, UnsupportedError
from phichain.orbits.forced import by_shooting
from phichain.orbits.forced.begun import begun, towards
from phichain.orbits.forced.checkpoint import Checkpoint
from phichain.orbits.forced.floquet import tests_of
from phichain.orbits.forced.flow import EmittedFlow
from phichain.orbits.forced.forcing import Forcing
from phichain.orbits.forced.made import Motion, begun_of, ends_of, response_of
from phichain.orbits.forced.response import Response
from phichain.orbits.forced.series import NEEDED, Found, forced_problem, least_outer, outer_of, table_of
from phichain.orbits.forced.solved import Record
from phichain.orbits.harmonics.elimination import Harmonics, Memory
from phichain.system import Parameters, System, Vector

USUAL: Final = Harmonics(tail=1e-8)
"""Folds keep ten digits: they are stationary, and what the tail leaves out enters squared."""
_COARSE: Final = 1e-3
"""Smallest step with which it is tried to eliminate all harmonics above the third."""
UNRESOLVED: Final = "tail of the spectrum"


@dataclass(frozen=True)
class _Unresolved:
    """The tail of the spectrum grows beyond what is wanted, the number of harmonics being as high as it may be."""

    wanted: Harmonics
    name: str = UNRESOLVED
    terminal: bool = True

    def value(self, problem: Problem, point: Point) -> float:
        """Decades between the tail and what is wanted."""
        found = point.extra
        return float(np.log10(max(found.series.tail, 1e-300) / self.wanted.tail)) if isinstance(found, Found) else 1.0


def followed(
    system: System, forcing: Forcing, ends: tuple[float, float], p: Parameters | None, wanted: Harmonics, engine: Engine,
    progress: Progress | None, earlier: Response | None = None,
) -> Response:  # fmt: skip
    """The response between two frequencies, or an earlier one gone on with.

    Raises:
        UnsupportedError: The system lacks what the balance needs.
        ConvergenceError: Newton did not reach a solution at the first frequency, or its series is too long.
    """
    absent = [name for name in NEEDED if not system.has(name)]
    if absent or system.real != "double":
        lacks = f"the function {absent[0]}" if absent else 'double precision, [target] real = "double"'
        raise UnsupportedError(
            "method", "harmonics", f"system '{system.name}' lacks {lacks}", f"build its scene with [functions] want = {list(NEEDED)}"
        )
    few, many = least_outer(forcing), outer_of(system, forcing, p, min(ends))
    at = None if earlier is None else earlier.checkpoint
    if earlier is not None and at is not None and at.why:
        first = begun_of(earlier, at)
        return by_shooting.gone_on(system, forcing, ends, EmittedFlow(system, forcing, p), engine, progress, first, at.why, at.branch)
    own = few if at is None else (len(at.branch.names) - 1) // system.nq
    # A run that is gone on with has as many as it had, whatever the range is now.
    many = many if own == few else own
    if own == few < many:
        # Where a higher harmonic resonates nothing can be eliminated; that shows by steps that shrink, and is rare where there are losses.
        quick = replace(engine, options=replace(engine.options, step_min=min(_COARSE, engine.options.step)))
        try:
            found = _followed(system, forcing, ends, p, wanted, quick, progress, few, at)
        except ConvergenceError:
            found = None
        if found is not None and found.status != "step":
            return found
        at = None
    return _followed(system, forcing, ends, p, wanted, engine, progress, many, at)


def _followed(
    system: System, forcing: Forcing, ends: tuple[float, float], p: Parameters | None, wanted: Harmonics, engine: Engine,
    progress: Progress | None, outer: int, earlier: Checkpoint | None,
) -> Response:  # fmt: skip
    """The response with so many functions that are not eliminated."""

    memory, typical = Memory(), max(ends) if earlier is None else float(earlier.branch.scale[-1])

    def problem_of(amplitude: float, memory: Memory | None = None) -> Problem:
        own = replace(forcing, amplitude=amplitude)
        return forced_problem(system, own, p, omega=typical, outer=outer, harmonics=wanted, memory=memory)

    record = Record(problem_of(forcing.amplitude, memory), memory)
    first: Point | Branch
    if earlier is None:
        z = begun(problem_of, forcing.amplitude, np.append(np.zeros(outer * system.nq), ends[0]), ends, engine)
        first = start_on(record.problem, z, towards(z, ends), engine, fixed=True)
        if isinstance(first.extra, Found) and (left := first.extra.series.tail) > wanted.tail:
            raise ConvergenceError(
                "harmonics", wanted.most, f"leave a tail of {left:.2g} at the first frequency, above {wanted.tail:g}",
                'allow more of them or a longer tail, lower the amplitude, or use method = "shooting"',
            )  # fmt: skip
        record.take(first.z(record.problem))
    else:
        record.restore(earlier, system, forcing, p)
        first = earlier.branch
    tests = [*tests_of(system, forcing.is_odd), _Unresolved(wanted), *ends_of(ends)]
    branch = follow(record.problem, first, engine, tests, "response", progress=record.told(progress))
    checkpoint = record.checkpoint(branch)

    def motion(z: Vector) -> Motion:
        coefficients = record.series(z)
        return Motion(table_of(forcing, len(coefficients)), coefficients, float(z[-1]))

    def told(branch: Branch) -> Response:
        return replace(response_of(system, forcing, branch, "harmonics", motion), checkpoint=checkpoint)

    if branch.status != "event" or branch.events[-1].kind != UNRESOLVED:
        return told(branch)
    # The last point is the one whose tail is as long as it may be.
    why = f"the harmonics up to {wanted.most} leave a tail above {wanted.tail:g} from omega = {branch.events[-1].z[-1]:.6g} on"
    whole = replace(branch, events=branch.events[:-1])
    try:
        flow = EmittedFlow(system, forcing, p)
    except UnsupportedError as lacking:
        return told(replace(whole, reason=f"{why}, where {lacking.remedy}"))
    return by_shooting.gone_on(system, forcing, ends, flow, engine, progress, told(whole), why)

