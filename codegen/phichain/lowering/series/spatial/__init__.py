"""The Taylor recurrences of spatial chains: by tensions where every mass sits at its link's end, else by an articulated sweep."""

from __future__ import annotations

from phichain.lowering.chain.body import has_points, point_masses
from phichain.lowering.series.series import Series
from phichain.lowering.series.spatial.articulated import articulated_series
from phichain.lowering.series.spatial.rigid import rigid_series
from phichain.lowering.series.spatial.tension import tension_series
from phichain.mechanics import Model


def spatial_series(model: Model) -> Series:
    """The recurrences of a spatial scene."""
    scene = point_masses(model.scene)
    if scene.inertia is not None and not has_points(scene):
        return rigid_series(model)
    return tension_series(model) if scene.tip_masses else articulated_series(model)
