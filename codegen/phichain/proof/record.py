"""What was proven of a scene's functions, and what stands in where nothing could be."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType


@dataclass(frozen=True)
class Proven:
    """One function.

    Attributes:
        name: its name.
        how: "modulo 2^61 - 1, 3 points", or what stands in for it and why.
        is_exact: whether it was proven.
        seconds: CPU time that it took; no part of a file.
    """

    name: str
    how: str
    is_exact: bool
    seconds: float = field(default=0.0, compare=False)


@dataclass(frozen=True)
class Proof:
    """The outcome for one scene.

    Attributes:
        scene: its name.
        digest: its digest, from which the random points follow.
        functions: every wanted function, and the helpers that they call.
        seconds: CPU time of all of it; no part of a file.
    """

    scene: str
    digest: str
    functions: tuple[Proven, ...]
    seconds: float = field(default=0.0, compare=False)

    @property
    def record(self) -> Mapping[str, str]:
        """How each function was proven, by name: the same text for the same scene."""
        return MappingProxyType({entry.name: entry.how for entry in self.functions})

    @property
    def exact(self) -> tuple[str, ...]:
        """The functions that were proven."""
        return tuple(entry.name for entry in self.functions if entry.is_exact)

    def __str__(self) -> str:
        width = max(len(entry.name) for entry in self.functions) if self.functions else 0
        lines = [f"{entry.name:{width}}  {entry.how}" for entry in self.functions]
        rest = len(self.functions) - len(self.exact)
        left = f", {rest} by other means" if rest else ""
        return "\n".join([*lines, f"{self.scene}: {len(self.exact)} proven exactly{left}, {self.seconds:.2f} s"])
