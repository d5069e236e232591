"""Network: families of orbits and how they hang together, as a frozen record and on file."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Final

from phichain.continuation import Branch
from phichain.continuation.document import (
    POSSIBLE,
    branch_document,
    branch_fields,
    reading_document,
    values_of,
)
from phichain.reading import text_of
from phichain.records import Shown, write_json

HOW: Final = ("opens", "runs through", "goes on", "arrives", "joins", "left")
"""What there can be between an event and a branch: the branch begins there, runs on from there both ways, or
ends there; it is the very
family that passes there and was followed from elsewhere; or nothing was followed."""
STATUS: Final = ("whole", "limits", "interrupted")


@dataclass(frozen=True)
class Link:
    """What goes on beyond one event.

    Attributes:
        branch: The branch of the event, counted from 0.
        event: Its number among the branch's events, from 0.
        how: "opens": branch `to` begins there; "runs through": it is a cover, and branch `to` is one half of
            the family it covers; "goes on": branch `to` is the same family taken up elsewhere on its orbits;
            "arrives": branch `to` ends there; "joins": what opens is branch `to`, followed from another
            event; "left": nothing was followed.
        to: A branch, from 0; -1 for none.
        said: The same in words.
        way: Which of the ways on from the event it is, from 0: a branch point has two.
    """

    branch: int
    event: int
    how: str
    to: int
    said: str
    way: int = 0


@dataclass(frozen=True, eq=False, repr=False)
class Network(Shown):
    """Branches, and how they hang together.

    Attributes:
        name: What was followed.
        branches: The families; the first is the one that was asked for.
        links: What goes on beyond their events.
        status: "whole" (nothing is left that opens), "limits" (some was left, and its links say why) or
            "interrupted".
        reason: The same in words.
        scene: Name of the scene.
        digest: Its digest.
        mode: Number of the linear mode that the first branch started from; 0 for none.
    """

    name: str
    branches: tuple[Branch, ...]
    links: tuple[Link, ...]
    status: str
    reason: str
    scene: str = ""
    digest: str = ""
    mode: int = 0

    def __len__(self) -> int:
        return len(self.branches)

    def __str__(self) -> str:
        lines = [f"{self.name}: {len(self)} branches; {self.reason}"]
        for k, branch in enumerate(self.branches):
            lines.append(f"[{k}] {branch.name}: {len(branch)} points; {branch.reason}")
            for link in (link for link in self.links if link.branch == k):
                event = branch.events[link.event]
                lines.append(f"    {event.kind} at s = {event.arclength:.6g}, omega = {event.z[-1]:.10g}: {link.said}")
        return "\n".join(lines)

    def beyond(self, branch: int, event: int) -> tuple[Link, ...]:
        """The links of one event."""
        return tuple(link for link in self.links if (link.branch, link.event) == (branch, event))

    def to_json(self, path: Path | str) -> Path:
        """Write {"kind": "network", "branches": [each as a Branch writes itself], "links": [...], ...};
        `from_json` reads it, and runs go on from it.

        Raises:
            OutputError: The file cannot be written.
        """
        links = [asdict(link) for link in self.links]
        document = {
            "scene": self.scene, "digest": self.digest, "p": self.p, "mode": self.mode, "name": self.name,
            "branches": [branch_document(branch) for branch in self.branches], "links": links, "status": self.status, "reason": self.reason,
        }  # fmt: skip
        return write_json(path, "network", document)

    @classmethod
    def from_json(cls, path: Path | str) -> Network:
        """Read what `to_json` wrote.

        Raises:
            OutputError: The file is missing, cut short, or holds no Network.
        """
        found = reading_document(path, "network", cls._of)
        for k, branch in enumerate(found.branches):
            POSSIBLE.demand(path, branch, f"branches[{k}].")
        return found

    @classmethod
    def _of(cls, found: dict[str, Any]) -> Network:
        branches = tuple(Branch(**branch_fields(row)) for row in found["branches"])
        links = tuple(
            Link(int(row["branch"]), int(row["event"]), text_of(row, "how"), int(row["to"]), text_of(row, "said"), int(row["way"]))
            for row in found["links"]
        )
        if not branches or found["status"] not in STATUS:
            raise ValueError("it holds no branch, or no status that there is")
        for link in links:
            inside = 0 <= link.branch < len(branches) and -1 <= link.to < len(branches)
            if not inside or link.how not in HOW or not 0 <= link.event < len(branches[link.branch].events):
                raise ValueError("its links do not fit its branches")
        return cls(
            text_of(found, "name"), branches, links, text_of(found, "status"), text_of(found, "reason"), text_of(found, "scene"),
            text_of(found, "digest"), int(found["mode"]), p=values_of(found),
        )  # fmt: skip
