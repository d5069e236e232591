"""How many columns of derivatives a flow carries side by side, and the part of a workspace that they take."""

from __future__ import annotations

from typing import Any, Final

from phichain.lowering.series.series import HIGHEST, Series
from phichain.scene import Scene

#: Columns in one vector of lanes.
_WIDTHS: Final = (2, 4, 8)
#: Bytes of the widest vector by the macro of a processor that has them: wider ones would be taken apart in memory.
_WIDEST: Final = {"__AVX512F__": 64, "__AVX__": 32, "": 16}


def columns_at_once(scene: Scene) -> int:
    """How many columns are carried side by side at most: all of them where one vector holds them."""
    size = scene.nq + scene.nv
    return next((width for width in _WIDTHS if width >= size), _WIDTHS[-1])


def vector_bytes(scene: Scene) -> list[tuple[str, int]]:
    """Bytes of a vector of columns by what a processor has; the last for all others."""
    wanted = columns_at_once(scene) * (8 if scene.real == "double" else 4)
    sizes = {macro: min(wanted, widest) for macro, widest in _WIDEST.items()}
    return [(macro, size) for macro, size in sizes.items() if size != sizes[""] or not macro]


def rows_kept(scene: Scene, made: Series) -> dict[str, Any]:
    """Sizes of what is kept of the rows of derivatives: all of them, or by link what its angle and its joint's force are."""
    orders = HIGHEST[scene.real] + 1
    if not made.by_links:
        return {"links": 0, "room": 0, "kept": (orders, orders)}
    return {"links": made.lanes // 2, "room": -(-orders // _WIDTHS[-1]) * _WIDTHS[-1], "kept": (orders if made.dry else 2, 1)}


def workspace(scene: Scene, made: Series, highest: int) -> list[tuple[str, tuple[int, ...]]]:
    """Arrays of a workspace for derivatives."""
    size, varied = scene.nq + scene.nv, sum(scene.varied.values())
    kept = rows_kept(scene, made)
    lefts, rights = kept["kept"]
    numbers = (highest + 1) * (size + 3 * kept["links"]) + lefts * made.width + (rights * made.rights + 1) * made.lanes
    arrays: list[tuple[str, tuple[int, ...]]] = [("shared", (3, kept["links"], kept["room"]))] if made.by_links else []
    if made.order_along is not None:
        numbers += varied + made.held + (made.held + highest + 1 if made.is_forced else 0)
        arrays += [("kept", (highest, made.sums))]
        arrays += [("force", (highest + 1,))] if made.is_forced else []
    return [("columns", (numbers * columns_at_once(scene),)), *arrays, ("carried", (size * (size + varied),))]
