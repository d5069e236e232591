"""A sweep over a chain as a picture: what goes from the tip to the base, what is kept of each link, what goes back."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import Final

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from docs.figures.drawing import ACCENT, BLUE, GREEN, INK, SOFT, arrow, box, canvas, words

_COLUMNS: Final = (3.35, 6.3, 9.25)
_NAMES: Final = ("link 1", r"link $k$", r"link $N$")
_INWARDS, _KEPT, _OUTWARDS = 4.05, 2.55, 1.05
_WIDTH: Final = 1.62


@dataclass(frozen=True)
class Sweep:
    """What a sweep does, in the symbols of its section.

    Attributes:
        carried: what one link hands to the one before it.
        step: what a link does on the way to the base.
        kept: what is stored of each link for the way back.
        base: how the chain is closed at its base.
        returned: what one link hands to the next one on the way back.
        result: what comes out of a link on the way back.
        beyond: what there is beyond the tip.
    """

    carried: str
    step: str
    kept: str
    base: str
    returned: str
    result: str
    beyond: str = "nothing\nbeyond"


def draw_sweep(ax: Axes, sweep: Sweep) -> None:
    """Draw a sweep into an area."""
    ax.set_xlim(0.0, 11.3)
    ax.set_ylim(0.2, 5.15)
    for x, name in zip(_COLUMNS, _NAMES, strict=True):
        words(ax, (x, 4.95), name, color=SOFT, fontsize=8.5)
        box(ax, (x, _INWARDS), (_WIDTH, 1.0), sweep.step, color=ACCENT, fontsize=8.5)
        box(ax, (x, _KEPT), (_WIDTH, 0.9), sweep.kept, color=GREEN, fill="#f0f8f2", fontsize=8.5)
        box(ax, (x, _OUTWARDS), (_WIDTH, 1.0), sweep.result, color=BLUE, fontsize=8.5)
        arrow(ax, (x, _INWARDS - 0.5), (x, _KEPT + 0.45), color=GREEN)
        arrow(ax, (x, _KEPT - 0.45), (x, _OUTWARDS + 0.5), color=GREEN)
    words(ax, (0.85, 4.95), "base", color=SOFT, fontsize=8.5)
    box(ax, (0.85, _KEPT), (1.45, 4.0), sweep.base, color=INK, fontsize=8.5)
    edges = ((1.58, _COLUMNS[0] - _WIDTH / 2), *((a + _WIDTH / 2, b - _WIDTH / 2) for a, b in itertools.pairwise(_COLUMNS)))
    for left, right in edges:
        arrow(ax, (right, _INWARDS), (left, _INWARDS), sweep.carried, color=ACCENT, off=(0.0, 0.33), fontsize=8.0)
        arrow(ax, (left, _OUTWARDS), (right, _OUTWARDS), sweep.returned, color=BLUE, off=(0.0, 0.33), fontsize=8.0)
    right = _COLUMNS[-1] + _WIDTH / 2
    arrow(ax, (right + 0.32, _INWARDS), (right, _INWARDS), color=ACCENT)
    words(ax, (right + 0.76, _INWARDS), sweep.beyond, color=ACCENT, fontsize=7.5)
    for x in ((_COLUMNS[0] + _COLUMNS[1]) / 2, (_COLUMNS[1] + _COLUMNS[2]) / 2):
        words(ax, (x, _KEPT), "$\\cdots$", color=SOFT, fontsize=12)


def beside(sweep: Sweep) -> tuple[Figure, Axes]:
    """A sweep with an area for a sketch of one link to its left."""
    figure, (sketch, area) = canvas(8.6, 3.3, (0.005, 0.02, 0.24, 0.96), (0.25, 0.02, 0.75, 0.96))
    draw_sweep(area, sweep)
    return figure, sketch
