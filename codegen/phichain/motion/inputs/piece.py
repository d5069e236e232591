"""What an input is between two of its breaks: one constant, or a function that is as smooth as its maker made it."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np

from phichain.records import Held, held
from phichain.system import Vector

Control = Callable[[float, Vector], Vector]
"""u(t, x), shape (nu,)."""
NOTHING: Final = held(())
"""No input, and no time."""


@dataclass(frozen=True, eq=False)
class Piece(Held):
    """An input between two neighbouring breaks.

    Attributes:
        control: u(t, x) there, both ends included.
        held: The input where it is one constant, else None.
    """

    control: Control
    held: Vector | None

    @classmethod
    def constant(cls, u: Vector) -> Piece:
        """One constant input."""
        return cls.made(control=lambda t, x: u, held=u)


class Signal(ABC):
    """Some inputs over time and state."""

    @property
    @abstractmethod
    def is_held(self) -> bool:
        """Whether it is constant between breaks that are known beforehand."""

    @property
    def is_law(self) -> bool:
        """Whether a caller's function is asked for it."""
        return False

    @abstractmethod
    def breaks(self, low: float, high: float) -> Vector:
        """Times strictly between two others at which it, or its slope, jumps; rising."""

    @abstractmethod
    def piece(self, start: float, stop: float) -> Piece:
        """What it is between two neighbouring breaks, in either order."""

    @abstractmethod
    def value(self, t: float, x: Vector) -> Vector:
        """The inputs at one moment; at a jump those after it."""


@dataclass(frozen=True, eq=False)
class Constant(Held, Signal):
    """Inputs that never change.

    Attributes:
        u: Their values.
    """

    u: Vector
    is_held = True

    def breaks(self, low: float, high: float) -> Vector:
        """None."""
        return NOTHING

    def piece(self, start: float, stop: float) -> Piece:
        """The constant."""
        return Piece.constant(self.u)

    def value(self, t: float, x: Vector) -> Vector:
        """The constant."""
        return self.u


@dataclass(frozen=True, eq=False)
class Law(Signal):
    """Inputs that a caller's function gives.

    Attributes:
        control: u(t, x), shielded.
    """

    control: Control
    is_held = False
    is_law = True

    def breaks(self, low: float, high: float) -> Vector:
        """None that anybody knows of."""
        return NOTHING

    def piece(self, start: float, stop: float) -> Piece:
        """The law."""
        return Piece(self.control, None)

    def value(self, t: float, x: Vector) -> Vector:
        """What the law says."""
        return self.control(t, x)


@dataclass(frozen=True, eq=False)
class Together(Signal):
    """Inputs of several kinds side by side.

    Attributes:
        parts: For every part the entries of u that it fills, and the part; no entry twice.
        size: nu; an entry that no part fills is 0.
    """

    parts: tuple[tuple[tuple[int, ...], Signal], ...]
    size: int

    @property
    def is_held(self) -> bool:
        """Whether all parts are."""
        return all(part.is_held for _, part in self.parts)

    @property
    def is_law(self) -> bool:
        """Whether one of the parts is."""
        return any(part.is_law for _, part in self.parts)

    def breaks(self, low: float, high: float) -> Vector:
        """Those of all parts."""
        return np.unique(np.concatenate([np.empty(0), *(part.breaks(low, high) for _, part in self.parts)]))

    def piece(self, start: float, stop: float) -> Piece:
        """The parts' pieces, each in its entries."""
        pieces = [(list(at), part.piece(start, stop)) for at, part in self.parts]
        if all(piece.held is not None for _, piece in pieces):
            return Piece.constant(self._filled([(at, piece.held) for at, piece in pieces]))
        return Piece(lambda t, x: self._filled([(at, piece.control(t, x)) for at, piece in pieces]), None)

    def value(self, t: float, x: Vector) -> Vector:
        """The parts' values, each in its entries."""
        return self._filled([(list(at), part.value(t, x)) for at, part in self.parts])

    def _filled(self, values: list[tuple[list[int], Vector | None]]) -> Vector:
        u = np.zeros(self.size)
        for at, value in values:
            u[at] = value
        return u
