"""The two words that every record knows, `plot` and `animate`, before any kind of record has said what they do."""

from __future__ import annotations

from functools import singledispatch
from pathlib import Path
from typing import Any

from phichain.errors import UnsupportedError


@singledispatch
def plot(record: Any, ax: Any = None, **words: Any) -> Any:
    """Draw a record: on axes, or as a figure of its own.

    Raises:
        UnsupportedError: Nothing draws such a record.
    """
    raise UnsupportedError("plot", type(record).__name__, "has no picture", "draw its arrays by matplotlib")


@singledispatch
def animate(record: Any, path: Path | str, **words: Any) -> Path:
    """Write a record in motion.

    Raises:
        UnsupportedError: Nothing of it moves.
    """
    raise UnsupportedError("animate", type(record).__name__, "holds no motion", "animate the Trajectory of a simulation, or an orbit picked out of a family")


def demand_figure(ax: Any, record: Any) -> None:
    """Refuse axes for a record whose picture is more than one panel.

    Raises:
        UnsupportedError: There are axes.
    """
    if ax is not None:
        raise UnsupportedError("ax", type(record).__name__, "is drawn on several panels", "leave ax out, and take the figure")
