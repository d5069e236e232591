"""Orbits: the families of oscillations of a chain, each a continuation problem made from a System."""

from phichain.orbits.modes import LinearModes, linear_modes
from phichain.orbits.single_harmonic import harmonic_problem, trace

__all__ = ["LinearModes", "harmonic_problem", "linear_modes", "trace"]
