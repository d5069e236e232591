"""Points that a compiled problem found at once: each is a record of its own when somebody asks for it, and all of them are columns of a Branch."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import fields
from typing import Any, Final, Protocol

import numpy as np

from phichain.continuation.point import Point

_FIELDS: Final = frozenset(item.name for item in fields(Point))
_BLOCK: Final = "_block"


class Block(Protocol):
    """The points."""

    def fields(self, place: int) -> dict[str, Any]:
        """The fields of one of them."""
        ...

    def column(self, name: str) -> np.ndarray | None:
        """One field of all of them (m, ...), or their multipliers, or the "error" that their problem tells of each; None where each has to be asked."""
        ...


class BlockPoint(Point):
    """A point of a block, whose fields are taken out when one is first asked for: of most points of a run nobody does."""

    @classmethod
    def of(cls, block: Block, place: int) -> BlockPoint:
        """The one at a place of it."""
        point = cls.__new__(cls)
        vars(point)[_BLOCK] = block, place
        return point

    def __getattr__(self, name: str) -> Any:
        """A field that nobody has asked for yet.

        Raises:
            AttributeError: There is none of that name.
        """
        own = vars(self)
        block, place = own.get(_BLOCK, (None, 0))
        if name not in _FIELDS or (block is None and name not in own):
            raise AttributeError(name)
        if block is not None:
            # Let go when all is there: another thread may ask meanwhile, and what was interrupted can be asked again.
            own.update(block.fields(place))
            own.pop(_BLOCK, None)
        return own[name]


class Columns:
    """Fields of points one by one, as columns: of those in blocks whom nobody has asked all at once."""

    def __init__(self, points: Sequence[Point]) -> None:
        """Find the points that lie side by side in blocks."""
        self._pieces: list[tuple[Block | None, int, list[Point]]] = []
        for point in points:
            block, place = vars(point).get(_BLOCK, (None, 0))
            last, begin, together = self._pieces[-1] if self._pieces else (None, 0, [])
            if block is last and together and (block is None or place == begin + len(together)):
                together.append(point)
            else:
                self._pieces.append((block, place, [point]))

    def of(self, name: str, each: Callable[[Point], Any]) -> np.ndarray:
        """A column (m, ...), and how each point is asked for it."""
        parts = []
        for block, begin, points in self._pieces:
            known = None if block is None else block.column(name)
            parts.append(np.array([each(point) for point in points]) if known is None else known[begin : begin + len(points)])
        return np.concatenate(parts)
