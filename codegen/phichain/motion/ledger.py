"""The ledger of a run: what a method counts and has to say on its way, read when it has ended."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from phichain.motion.balance import Account
from phichain.motion.inputs.legs import Legs
from phichain.motion.problem import Counted


@dataclass(eq=False)
class Ledger:
    """Written by the method that runs, while every record of the problem stays as it was made.

    Attributes:
        counts: What a method counts for itself; empty where its steps and calls are counted from outside.
        remarks: What it has to say of its run, for the Trajectory's reason.
        account: Where work and loss are booked on the way, or None where nobody asks.
        legs: The input as it was, leg after leg, once the run has begun.
        is_watched: Whether a flow that can is to leave its steps, by which somebody may ask how large its errors are.
    """

    counts: dict[str, int] = field(default_factory=dict)
    remarks: list[str] = field(default_factory=list)
    account: Account | None = None
    legs: Legs | None = None
    is_watched: bool = False

    def count(self, **more: int) -> None:
        """Add to counts; one that is new starts at zero."""
        for key, value in more.items():
            self.counts[key] = self.counts.get(key, 0) + value

    def counted(self, steps: int, calls: Mapping[str, Counted | None]) -> dict[str, int]:
        """What the method counted for itself, or else its steps and the calls of what was handed to it."""
        if self.counts:
            return dict(self.counts)
        return {"steps": steps} | {name: function.calls for name, function in calls.items() if function is not None}
