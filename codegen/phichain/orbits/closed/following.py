"""Following a family of any kind to its end, with its events under their names."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

from phichain.continuation import Branch, Engine, Point, Problem, Special, TestFunction, follow
from phichain.continuation.core import Progress
from phichain.orbits.closed.arrivals import arrival, shorter_orbit
from phichain.orbits.closed.kinds import PHASE_LOSS, ends_of, events_of, said_of, small
from phichain.orbits.covers import mode_of
from phichain.orbits.modes import LinearModes
from phichain.orbits.shooting import finished
from phichain.orbits.symmetry import BRANCH_POINT
from phichain.system import Parameters, System

_BESIDE: Final = 1e-5
"""Arclength within which what turns at a mirror is found."""


@dataclass(frozen=True)
class Follower:
    """What families are followed with.

    Attributes:
        system: The chain.
        p: Runtime parameters.
        modes: Its linear modes.
        engine: Predictor, corrector and options.
        through: Half width of gaps that are crossed.
        progress: Told every new point.
    """

    system: System
    p: Parameters | None
    modes: LinearModes
    engine: Engine
    through: float
    progress: Progress | None

    def follow(
        self, kind: str, problem: Problem, start: Point | Branch, name: str, tests: Sequence[TestFunction] = ()
    ) -> Branch:
        """One branch to its end; `tests` are looked for besides its kind's own."""
        origin = start.z(problem) if isinstance(start, Point) else start.points[0]
        own, longest = self.engine.options, 1.5 * small(problem, origin, self.system.cart_size)
        options = replace(
            own, step_max=min(own.step_max, longest), step=min(own.step, longest), step_min=min(own.step_min, longest)
        )
        ends = ends_of(self.system, kind, problem, origin)
        looked = [*events_of(self.system, self.p, kind, problem), *tests, *ends]
        found = follow(
            problem, start, replace(self.engine, options=options), looked, name, through=self.through, progress=self.progress
        )
        if kind == "quarter":
            found = finished(self.system, self.p, self.modes, found)
        else:
            found = replace(found, events=self.named(kind, found))
        if arrival(self.system, self.p, replace(found, closing=kind)) is not None:
            found = replace(found, reason=f"ended where it meets its own mirror image, at the {found.events[-1].kind}")
        return replace(
            found, scene=self.system.name, digest=self.system.digest, method="shooting", closing=kind, p=self.system.values(self.p)
        )


    def named(self, kind: str, branch: Branch) -> tuple[Special, ...]:
        """The events of a kind other than brake orbits: covers under their names, and nothing that only seems
        to turn at its end."""
        own = [self.cover(kind, event) if event.kind == BRANCH_POINT else event for event in branch.events]
        is_mirror = arrival(self.system, self.p, replace(branch, closing=kind, events=tuple(own))) is not None
        if is_mirror or (own and own[-1].kind == PHASE_LOSS):
            end = own[-1].arclength
            own = [event for event in own[:-1] if abs(event.arclength - end) > _BESIDE] + own[-1:]
        return tuple(said_of(kind, event) for event in own)

    def cover(self, kind: str, event: Special) -> Special:
        """A branch point under its own name: "cover K of mode J", or as it is."""
        own, z = shorter_orbit(self.system, self.p, kind, event.z)
        times = round(float(z[-1] / event.z[-1]))
        if times == 1:
            return event
        mode = mode_of(self.system, self.p, self.modes, z) if own == "quarter" else 0
        return replace(event, kind=f"cover {times} of {f'mode {mode}' if mode else f'an orbit of omega {z[-1]:.10g}'}")
