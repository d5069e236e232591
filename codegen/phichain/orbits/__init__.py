"""Orbits: the families of oscillations of a chain, each a continuation problem made from a System."""

from phichain.orbits.forced import Forcing, Response, respond
from phichain.orbits.modes import LinearModes, linear_modes
from phichain.orbits.periodic import half_problem, whole_problem
from phichain.orbits.quarter import QuarterMap, quarter_problem
from phichain.orbits.single_harmonic import harmonic_problem
from phichain.orbits.tracing import trace

__all__ = [
    "Forcing",
    "LinearModes",
    "QuarterMap",
    "Response",
    "half_problem",
    "harmonic_problem",
    "linear_modes",
    "quarter_problem",
    "respond",
    "trace",
    "whole_problem",
]
