"""What carries a chain, as a record: everything that any layer asks of a base."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Axes = Literal["none", "horizontal", "down", "all"]
"""Axes of space: the d - 1 horizontal ones, the last, which gravity acts along, or all."""


@dataclass(frozen=True)
class BaseLaw:
    """A base: which of its motions are coordinates, which are told it, and how it is spoken of.

    A base has the acceleration p_0'' = C x'' + E b. C x are the motions that it has coordinates x for, at the head of q and v; b are
    accelerations that it is told, the first entries of u, along the axes in E. Without coordinates for them, C = 0, the chain hangs
    on a wall that falls with b; with them the rows of x say x'' = b; a base that is told nothing has an equation of motion
    of its own for them, a mass, dampers and dry friction, and a force in u where the scene's inputs act on it.

    Attributes:
        base: The word of `chain.base`.
        drive: The word of `chain.drive`, None where the base has no such choice; the first law of a base is what it means unless said.
        placed: The axes that it has coordinates along.
        told: The axes along which its acceleration is an input.
        on: Where the chain hangs, of a scene's title: "... links on a cart".
        noun: What it is, where a Model is printed: "... chain of 2 links on a fixed base".
        drawing: The lines above the first joint in a scene's sketch; those of a base with coordinates hold its numbers beside them.
        input: Stem of the names in u of what drives it, "" where nothing does.
        unit: And its unit.
        meaning: What these entries of u are, in the header; `{size}` is their number.
        place: The word of `forcing.forced` that means it, None where A cos(omega t) cannot drive it.
        driven: What the forcing then is: "the force on the cart".
        argument: What its acceleration is as an argument of `inverse_dynamics`, in the header.
        left_out: Why the folder holds no terms of a cart; "" where it does.
    """

    base: str
    drive: str | None
    placed: Axes
    told: Axes
    on: str
    noun: str
    drawing: tuple[str, ...]
    input: str = ""
    unit: str = ""
    meaning: str = ""
    place: str | None = None
    driven: str = ""
    argument: str = ""
    left_out: str = ""

    @property
    def is_placed(self) -> bool:
        """Whether q and v hold where it is."""
        return self.placed != "none"

    @property
    def is_told(self) -> bool:
        """Whether u holds its acceleration."""
        return self.told != "none"

    @property
    def is_free(self) -> bool:
        """Whether it has an equation of motion of its own, with a mass in it."""
        return self.is_placed and not self.is_told

    @property
    def rests(self) -> bool:
        """Whether it does not move at all."""
        return not (self.is_placed or self.is_told)


def axes_of(axes: Axes, size: int) -> tuple[int, ...]:
    """The axes, counted from 0, of a space of 2 or 3 dimensions."""
    return {"none": (), "horizontal": tuple(range(size - 1)), "down": (size - 1,), "all": tuple(range(size))}[axes]
