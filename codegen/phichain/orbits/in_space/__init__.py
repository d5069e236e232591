"""Brake orbits of spatial chains whose rests lie off any plane."""

from phichain.orbits.in_space.family import START, from_plane, settings, trace_in_space
from phichain.orbits.in_space.problem import METHOD, space_problem, state_at_rest

__all__ = ["METHOD", "START", "from_plane", "settings", "space_problem", "state_at_rest", "trace_in_space"]
