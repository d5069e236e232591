"""Taylor recurrences of a chain: order by order with one factorisation a step (docs/theory.md, Taylor flow)."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

from phichain.lowering.series.forced import forced, with_inputs
from phichain.lowering.series.planar import planar_series
from phichain.lowering.series.planar_single import single_series
from phichain.lowering.series.series import Series
from phichain.lowering.series.spatial import spatial_series
from phichain.lowering.series.varied import with_parameters
from phichain.mechanics import Model


@lru_cache(maxsize=4)
def series(model: Model) -> Series:
    """The Taylor recurrences of a scene; those of the last few Models are kept, as proof and flows ask for the same."""
    made = _forced(model) if model.scene.forced is not None else _unforced(model)
    return with_parameters(made, model.scene) if model.scene.varied else made


def _forced(model: Model) -> Series:
    view = with_inputs(model.scene)
    return forced(_unforced(replace(model, scene=view)), model.scene, view)


def _unforced(model: Model) -> Series:
    if not model.scene.is_planar:
        return spatial_series(model)
    # In its own frame a single link sees a base that is forced turn; the frames of more links are at rest.
    if model.scene.links == 1 and not model.scene.has_cart and model.scene.forced != "base":
        return single_series(model)
    return planar_series(model)


__all__ = ["Series", "series"]
