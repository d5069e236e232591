"""Growing a network: every event that opens a branch is gone through, breadth first; what is known already is
joined and not followed twice.

Nothing but the record is carried from one event to the next, so that a run that was interrupted goes on to
the same network.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np

from phichain.continuation import Branch, Point, Problem, Special, start_on
from phichain.errors import ConvergenceError
from phichain.orbits.closed.arrivals import arrival
from phichain.orbits.closed.following import Follower
from phichain.orbits.closed.kinds import KINDS, PHASE_LOSS, problem_of
from phichain.orbits.network.opening import Opening, first_points, opening_at, regular_opening, settled
from phichain.orbits.network.recognition import branch_with, event_like, invariants
from phichain.orbits.network.record import Link, Network

POINTS: Final = 400
"""Points of a branch that an event opens, unless the options allow fewer."""
_LIMITS: Final = "left for the limits: "


class _InterruptedError(Exception):
    """Ctrl-C ended a branch."""


@dataclass(frozen=True)
class Growing(Follower):
    """What a network is grown with.

    Attributes:
        generations: How far from the first branch events are gone through.
        most: Branches at most.
    """

    generations: int
    most: int


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
            first.scene, first.digest, first.mode, p=first.p,
        )  # fmt: skip

    def resume(self) -> None:
        """Go on with a branch that was interrupted; it is the last."""
        last, own = self.branches[-1], self.growing
        if len(self.branches) > 1 and last.status == "interrupted":
            problem = replace(problem_of(own.system, own.p, last.closing, last.points[0]), scale=last.scale)
            # As many points in all as it would have had at once.
            options = replace(own.engine.options, max_points=max(2, own.engine.options.max_points - last.regular + 1))
            follower = replace(own, engine=replace(own.engine, options=options))
            found = follower.follow(last.closing, problem, last, last.name)
            if found.status == "points":
                found = replace(found, reason=f"max_points = {own.engine.options.max_points} reached")
            self.branches[-1] = found
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
        is_same = event.kind == PHASE_LOSS
        left = self.limit(k, is_same)
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
            elif limit := self.limit(k, is_same):
                self.link(k, number, "left", -1, limit, way)
            else:
                self.follow(k, number, way, opened, problem, point)

    def opening(self, k: int, number: int) -> Opening | str | None:
        """What opens at an event, or why nothing does; None where the branch ended at an orbit that is known
        by now."""
        own, branch = self.growing, self.branches[k]
        event = branch.events[number]
        if number == len(branch.events) - 1 and (more := arrival(own.system, own.p, branch)) is not None:
            return None if self.arrived(k, number) else regular_opening(own.system, own.p, *more)
        covers = [other for other in branch.events if other.kind.startswith("cover")]
        if event.kind == "brake loss" and any(np.allclose(event.z, other.z, rtol=1e-8, atol=1e-10) for other in covers):
            return "nothing but the family that it covers: there mu touches 1 with both of its vectors"
        return opening_at(own.system, own.p, branch, event)

    def known(self, k: int, number: int, opened: Opening, problem: Problem, point: Point) -> int | None:
        """The branch on which a first point lies, of those that do not run on from the same event; None where
        it lies on none."""
        own = self.growing
        beside = {link.to for link in self.links if opened.is_regular and (link.branch, link.event) == (k, number)}
        if self.branches[k].events[number].kind == PHASE_LOSS:
            beside.add(k)
        others = [at for at in range(len(self.branches)) if at not in beside]
        found = branch_with(own.system, own.p, [self.branches[at] for at in others], opened.kind, point, problem, own.engine)
        return None if found is None else others[found]

    def follow(self, k: int, number: int, way: int, opened: Opening, problem: Problem, point: Point) -> None:
        event = self.branches[k].events[number]
        name = f"{self.growing.system.name}, {KINDS[opened.kind].words}, from the {event.kind} at omega = {event.z[-1]:.10g}"
        self.branches.append(self.growing.follow(opened.kind, problem, point, name))
        to = len(self.branches) - 1
        how = "opens" if not opened.is_regular else "goes on" if event.kind == PHASE_LOSS else "runs through"
        said = f"[{to}] runs through" if how == "runs through" else f"{how} as [{to}]" if how == "goes on" else f"opens [{to}]"
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

    def limit(self, k: int, is_same: bool = False) -> str:
        """Why nothing more is followed beyond a branch (the same family under another phase: `is_same`), in
        words; empty where there is no reason."""
        own, generation = self.growing, self.generation(k)
        if generation >= own.generations and not is_same:
            return f"{_LIMITS}it is of generation {generation + 1}"
        return f"{_LIMITS}there are {own.most} branches already" if len(self.branches) >= own.most else ""

    def generation(self, k: int) -> int:
        """How many events lie between a branch and the first one."""
        begun = [link for link in self.links if link.to == k and link.how in ("opens", "runs through", "goes on")]
        return 0 if k == 0 or not begun else (begun[0].how != "goes on") + self.generation(begun[0].branch)

    def link(self, k: int, number: int, how: str, to: int, said: str, way: int = 0) -> None:
        self.links.append(Link(k, number, how, to, said, way))


def _opens(branch: Branch, event: Special) -> bool:
    return event.kind.startswith("cover") or event.kind in KINDS[branch.closing].opens
