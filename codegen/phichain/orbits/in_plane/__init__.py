"""Brake orbits of spatial chains that swing in a vertical plane."""

from phichain.orbits.in_plane.family import (
    PLANE_LOSS,
    START,
    events_of,
    plane_modes,
    settings,
    trace_in_plane,
)
from phichain.orbits.in_plane.problem import METHOD, NEEDED, SpatialMap, at_rest, plane_problem

__all__ = ["METHOD", "NEEDED", "PLANE_LOSS", "START", "SpatialMap", "at_rest", "events_of", "plane_modes", "plane_problem", "settings", "trace_in_plane"]
