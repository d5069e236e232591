"""The record of a spatial chain's recurrences, alike in all three forms but for what is held, its factorisation and its order."""

from __future__ import annotations

from collections.abc import Callable

from phichain.lowering.series.held import Layout
from phichain.lowering.series.series import Series
from phichain.lowering.series.spatial.columns import columns_program
from phichain.lowering.series.spatial.ordering import Ordering, RowsShared, order_program
from phichain.lowering.series.spatial.rows import Factoring, factor_program, right_rows
from phichain.lowering.series.spatial.rubs import places
from phichain.mechanics import Model
from phichain.scene import Scene


def spatial_series(model: Model, scene: Scene, held: Layout, factor: Callable[[Factoring], None], order: Callable[[Ordering], None]) -> Series:
    """The recurrences of a spatial scene.

    Args:
        model: Its mechanics.
        scene: The scene, as point masses where the form takes them so.
        held: What a step holds.
        factor: Writes that.
        order: Writes one order from those before it.
    """
    return Series(
        factor=factor_program(model, held, factor),
        order=order_program(model, held, order),
        columns=columns_program(scene) if scene.variational else None,
        lanes=3 * scene.links,
        rights=right_rows(scene),
        squares=3 * scene.links,
        held=held.size,
        rubs=places(scene),
        order_shared=order_program(model, held, order, RowsShared),
    )
