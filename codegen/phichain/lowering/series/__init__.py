"""Taylor recurrences of a chain: order by order with one factorisation a step (docs/theory.md, Taylor flow)."""

from __future__ import annotations

from functools import lru_cache

from phichain.contract.functions import ROWS
from phichain.errors import UnsupportedError
from phichain.lowering.series.planar import planar_series
from phichain.lowering.series.planar_single import single_series
from phichain.lowering.series.series import Series
from phichain.lowering.series.spatial import spatial_series
from phichain.mechanics import Model


@lru_cache(maxsize=4)
def series(model: Model) -> Series:
    """The Taylor recurrences of a scene; those of the last few Models are kept, as proof and flows ask for the same.

    Raises:
        UnsupportedError: Spatial links may be held at their centres of mass, which has none here.
    """
    absent = ROWS["propagate"].absence(model.scene)
    if absent is not None:
        raise UnsupportedError("functions.want", "propagate", absent.problem, absent.remedy)
    if not model.scene.is_planar:
        return spatial_series(model)
    if model.scene.links == 1 and not model.scene.has_cart:
        return single_series(model)
    return planar_series(model)


__all__ = ["Series", "series"]
