"""The Taylor recurrences of spatial chains: by tensions where every mass sits at its link's end, else by the articulated sweep."""

from __future__ import annotations

from phichain.lowering.chain.body import point_masses
from phichain.lowering.series.series import Series
from phichain.lowering.series.spatial.articulated import articulated_series
from phichain.lowering.series.spatial.tension import tension_series
from phichain.mechanics import Model


def spatial_series(model: Model) -> Series:
    """The recurrences of a spatial scene."""
    return tension_series(model) if point_masses(model.scene).tip_masses else articulated_series(model)
