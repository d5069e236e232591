"""Growing a network: every event that opens a branch is gone through, breadth first; what is known already is joined and not followed twice.

Nothing but the record is carried from one event to the next, so that a run that was interrupted goes on to the same network.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np

from phichain.continuation import Branch, Engine, Point, Problem, Special, follow, start_on
from phichain.continuation.core import Progress
from phichain.errors import ConvergenceError
from phichain.orbits.closed.kinds import KINDS, ends_of, events_of, problem_of, said_of, small
from phichain.orbits.covers import mode_of
from phichain.orbits.modes import LinearModes
from phichain.orbits.network.opening import Opening, arrival, first_points, opening_at, regular_opening, settled, shorter_orbit
from phichain.orbits.network.recognition import branch_with, event_like, invariants
from phichain.orbits.network.record import Link, Network
from phichain.orbits.shooting import finished
from phichain.orbits.symmetry import BRANCH_POINT
from phichain.system import Parameters, System

POINTS: Final = 400
"""Points of a branch that an event opens, unless the options allow fewer."""
_BESIDE: Final = 1e-5
"""Arclength within which what turns at a mirror is found."""
_LIMITS: Final = "left for the limits: "


class _InterruptedError(Exception):
    """Ctrl-C ended a branch."""


@dataclass(frozen=True)
class Growing:
    """What a network is grown with.

    Attributes:
        system: The chain.
        p: Runtime parameters.
        modes: Its linear modes.
        engine: Predictor, corrector and options.
        through: Half width of gaps that are crossed.
        generations: How far from the first branch events are gone through.
        most: Branches at most.
        progress: Told every new point.
    """

    system: System
    p: Parameters | None
    modes: LinearModes
    engine: Engine
    through: float
    generations: int
    most: int
    progress: Progress | None

    def follow(self, kind: str, problem: Problem, start: Point | Branch, name: str) -> Branch:
        """One branch to its end, with its events under their names."""
        origin = start.z(problem) if isinstance(start, Point) else start.points[0]
        own, longest = self.engine.options, 1.5 * small(problem, origin, self.system.cart_size)
        options = replace(
            own, max_points=min(POINTS, own.max_points), step_max=min(own.step_max, longest), step=min(own.step, longest),
            step_min=min(own.step_min, longest),
        )  # fmt: skip
        tests = [*events_of(self.system, self.p, kind, problem), *ends_of(self.system, kind, problem, origin)]
        found = follow(
            problem, start, replace(self.engine, options=options), tests, name, through=self.through, progress=self.progress
        )
        if kind == "quarter":
            found = finished(self.system, self.p, self.modes, found)
        else:
            found = replace(found, events=self.named(kind, found))
        if arrival(self.system, self.p, replace(found, closing=kind)) is not None:
            found = replace(found, reason=f"ended where it meets its own mirror image, at the {found.events[-1].kind}")
        return replace(
            found, scene=self.system.name, digest=self.system.digest, method="shooting", closing=kind
        )


    def named(self, kind: str, branch: Branch) -> tuple[Special, ...]:
        """The events of a kind other than brake orbits: covers under their names, and nothing that turns because the branch meets its own mirror image."""
        own = [self.cover(kind, event) if event.kind == BRANCH_POINT else event for event in branch.events]
        if own and arrival(self.system, self.p, replace(branch, closing=kind, events=tuple(own))) is not None:
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


def grow(growing: Growing, first: Branch | Network) -> Network:
    """The network of a branch, or what an earlier one becomes when it is gone on with.

    Args:
        growing: What it is grown with.
        first: The branch that was asked for, or an earlier network.
    """
    if isinstance(first, Branch):
        run = _Growth(growing, [first])
    else:
        kept = [link for link in first.links if link.how != "left"]
        run = _Growth(growing, list(first.branches), kept)
    status = "interrupted"
    try:
        if run.branches[0].status != "interrupted":
            run.resume()
            run.go_through()
            status = "limits" if any(link.said.startswith(_LIMITS) for link in run.links) else "whole"
    except (KeyboardInterrupt, _InterruptedError):
        pass
    return run.record(status)


_REASONS: Final = {
    "whole": "all that opens was followed",
    "limits": "some of what opens was left for the limits",
    "interrupted": "interrupted; what there is can be gone on with",
}


@dataclass
class _Growth:
    """A network on its way."""

    growing: Growing
    branches: list[Branch]
    links: list[Link] = field(default_factory=list)

    def record(self, status: str) -> Network:
        first, ordered = self.branches[0], sorted(self.links, key=lambda link: (link.branch, link.event, link.way))
        return Network(
            f"{first.name}, and what opens", tuple(self.branches), tuple(ordered), status, _REASONS[status],
            first.scene, first.digest, first.mode,
        )  # fmt: skip

    def resume(self) -> None:
        """Go on with a branch that was interrupted; it is the last."""
        last, own = self.branches[-1], self.growing
        if len(self.branches) > 1 and last.status == "interrupted":
            problem = replace(problem_of(own.system, own.p, last.closing, last.points[0]), scale=last.scale)
            self.branches[-1] = own.follow(last.closing, problem, last, last.name)
            self.ended(len(self.branches) - 1)

    def go_through(self) -> None:
        """All events of all branches, those of branches that are found on the way too."""
        k = 0
        while k < len(self.branches):
            for event in range(len(self.branches[k].events)):
                self.at(k, event)
            k += 1

    def at(self, k: int, number: int) -> None:
        """One event of one branch."""
        branch, known = self.branches[k], [link for link in self.links if (link.branch, link.event) == (k, number)]
        event = branch.events[number]
        if any(link.how == "arrives" for link in known) or not _opens(branch, event):
            return
        opened = self.opening(k, number)
        if opened is None:
            return
        if isinstance(opened, str):
            self.link(k, number, "left", -1, opened)
            return
        left = self.limit(k)
        problem, points = (None, [left] * len(opened.directions)) if left else first_points(
            self.growing.system, self.growing.p, opened, self.growing.engine
        )
        for way, point in enumerate(points):
            if any(link.way == way for link in known):
                continue
            if isinstance(point, str) or problem is None:
                self.link(k, number, "left", -1, str(point), way)
            elif (found := self.known(k, number, opened, problem, point)) is not None:
                self.link(k, number, "joins", found, f"joins [{found}]", way)
            elif self.limit(k):
                self.link(k, number, "left", -1, self.limit(k), way)
            else:
                self.follow(k, number, way, opened, problem, point)

    def opening(self, k: int, number: int) -> Opening | str | None:
        """What opens at an event, or why nothing does; None where the branch ended at an orbit that is known by now."""
        own, branch = self.growing, self.branches[k]
        event = branch.events[number]
        if number == len(branch.events) - 1 and (more := arrival(own.system, own.p, branch)) is not None:
            return None if self.arrived(k, number) else regular_opening(own.system, own.p, *more)
        covers = [other for other in branch.events if other.kind.startswith("cover")]
        if event.kind == "brake loss" and any(np.allclose(event.z, other.z, rtol=1e-8, atol=1e-10) for other in covers):
            return "nothing but the family that it covers: there mu touches 1 with both of its vectors"
        return opening_at(own.system, own.p, branch, event)

    def known(self, k: int, number: int, opened: Opening, problem: Problem, point: Point) -> int | None:
        """The branch on which a first point lies, of those that do not run on from the same event; None where it lies on none."""
        own = self.growing
        beside = {link.to for link in self.links if opened.is_regular and (link.branch, link.event) == (k, number)}
        others = [at for at in range(len(self.branches)) if at not in beside]
        found = branch_with(own.system, own.p, [self.branches[at] for at in others], opened.kind, point, problem, own.engine)
        return None if found is None else others[found]

    def follow(self, k: int, number: int, way: int, opened: Opening, problem: Problem, point: Point) -> None:
        event = self.branches[k].events[number]
        name = f"{self.growing.system.name}, {KINDS[opened.kind].words}, from the {event.kind} at omega = {event.z[-1]:.10g}"
        self.branches.append(self.growing.follow(opened.kind, problem, point, name))
        to = len(self.branches) - 1
        how, said = ("runs through", f"[{to}] runs through") if opened.is_regular else ("opens", f"opens [{to}]")
        self.link(k, number, how, to, said, way)
        self.ended(to)

    def ended(self, k: int) -> None:
        """Where a new branch has ended: at an event that is known, perhaps.

        Raises:
            _InterruptedError: By Ctrl-C.
        """
        branch = self.branches[k]
        if branch.status == "interrupted":
            raise _InterruptedError
        if arrival(self.growing.system, self.growing.p, branch) is not None:
            self.arrived(k, len(branch.events) - 1)

    def arrived(self, k: int, number: int) -> bool:
        """Whether a branch ended at an event that is known, which is then linked with it."""
        own, branch = self.growing, self.branches[k]
        if any((link.to == k and link.how == "arrives") or (link.branch, link.event) == (k, number) for link in self.links):
            return True
        more = arrival(own.system, own.p, branch)
        assert more is not None
        kind, z = more
        problem = problem_of(own.system, own.p, kind, z)
        try:
            z = settled(problem, z, own.engine)
        except ConvergenceError:
            return False
        target = invariants(problem, z)
        if (found := event_like(self.branches, kind, target, problem)) is not None:
            self.link(*found, "arrives", k, f"[{k}] arrives")
            return True
        point = start_on(problem, z, np.ones(len(z)), own.engine)
        passed = branch_with(own.system, own.p, self.branches, kind, point, problem, own.engine)
        if passed is not None:
            self.link(k, number, "joins", passed, f"ends on [{passed}]")
        return passed is not None

    def limit(self, k: int) -> str:
        """Why nothing more is followed beyond a branch, in words; empty where there is no reason."""
        own, generation = self.growing, self.generation(k)
        if generation >= own.generations:
            return f"{_LIMITS}it is of generation {generation + 1}"
        return f"{_LIMITS}there are {own.most} branches already" if len(self.branches) >= own.most else ""

    def generation(self, k: int) -> int:
        """How many events lie between a branch and the first one."""
        begun = [link.branch for link in self.links if link.to == k and link.how in ("opens", "runs through")]
        return 0 if k == 0 or not begun else 1 + self.generation(begun[0])

    def link(self, k: int, number: int, how: str, to: int, said: str, way: int = 0) -> None:
        self.links.append(Link(k, number, how, to, said, way))


def _opens(branch: Branch, event: Special) -> bool:
    return event.kind.startswith("cover") or event.kind in KINDS[branch.closing].opens
