"""What a run meets on its way: located events and avoided crossings."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from phichain.continuation.problem import Multipliers
from phichain.records import Held
from phichain.system import Vector

STATUS = ("event", "closed", "points", "step", "interrupted")
"""Why a run can end."""
_APART: Final = 1e-9
"""Arclength within which two events of one kind are one."""


@dataclass(frozen=True, eq=False)
class Special(Held):
    """A located event.

    Attributes:
        kind: Name of its test function.
        index: It lies between the points `index` and `index + 1` of the branch.
        z: The unknowns there (n + 1,).
        arclength: s there.
        value: What is left of the test function; how well it is located.
        multipliers: Those of the solution there (k,); empty where the method computes none.
        breaks: What it breaks, in words; empty where the method does not say.
        continues: Which problem goes on beyond it, in words.
        state: State (q, v) (nx,) that the unknowns stand for; None where they are a configuration at rest, and omega.
    """

    kind: str
    index: int
    z: Vector
    arclength: float
    value: float
    multipliers: Multipliers
    breaks: str = ""
    continues: str = ""
    state: Vector | None = None


@dataclass(frozen=True, eq=False)
class Passage(Held):
    """An avoided crossing that a run met.

    Attributes:
        z: The unknowns on the branch where it turned (n + 1,).
        arclength: s there.
        width: Half the width of the gap, in arclength.
        is_crossed: Whether the run went on beyond the gap, on the other branch, instead of turning with its own.
    """

    z: Vector
    arclength: float
    width: float
    is_crossed: bool


def is_same(event: Special, other: Special) -> bool:
    """Whether two events, of a run and of one that was cut and goes on, are one."""
    return event.kind == other.kind and event.index == other.index and bool(abs(event.arclength - other.arclength) < _APART)
