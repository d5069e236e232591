"""Conical families: relative equilibria of spatial chains, which turn about the vertical at a constant rate as if they were stiff."""

from phichain.orbits.conical.families import conical_families, trace_conical
from phichain.orbits.conical.problem import conical_problem
from phichain.orbits.conical.starts import NEEDED, Start, conical_starts
from phichain.orbits.conical.turning import Turning

__all__ = ["NEEDED", "Start", "Turning", "conical_families", "conical_problem", "conical_starts", "trace_conical"]
