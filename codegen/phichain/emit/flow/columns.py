"""How many columns of derivatives a flow carries side by side, and the part of a workspace that they take."""

from __future__ import annotations

from typing import Final

from phichain.lowering.series.series import Series
from phichain.scene import Scene

#: Columns in one vector of lanes.
_WIDTHS: Final = (2, 4, 8)


def columns_at_once(scene: Scene) -> int:
    """How many columns are carried side by side: whole vectors, few of them in vain."""
    size = scene.nq + scene.nv
    return min(_WIDTHS, key=lambda width: (-(-size // width) * width, -width))


def workspace(scene: Scene, made: Series, highest: int) -> list[tuple[str, tuple[int, ...]]]:
    """Arrays of a workspace for derivatives."""
    size, factors = scene.nq + scene.nv, made.lanes * (1 + made.rights)
    numbers = (highest + 1) * (size + factors) + made.lanes
    return [("columns", (numbers * columns_at_once(scene),)), ("carried", (size * size,))]
