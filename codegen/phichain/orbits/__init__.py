"""Orbits: the families of oscillations of a chain, each a continuation problem made from a System."""

from phichain.orbits.closed.reversible import reversible_problem
from phichain.orbits.conical import conical_families, conical_problem, conical_starts
from phichain.orbits.forced import Forcing, Response, respond
from phichain.orbits.modes import LinearModes, linear_modes
from phichain.orbits.network.record import Link, Network
from phichain.orbits.orbit import Orbit
from phichain.orbits.periodic import half_problem, whole_problem
from phichain.orbits.picking import pick
from phichain.orbits.quarter import QuarterMap, quarter_problem
from phichain.orbits.single_harmonic import harmonic_problem
from phichain.orbits.tracing import trace
from phichain.orbits.whirling import whirling_problem, whirls_of

__all__ = [
    "Forcing",
    "LinearModes",
    "Link",
    "Network",
    "Orbit",
    "QuarterMap",
    "Response",
    "conical_families",
    "conical_problem",
    "conical_starts",
    "half_problem",
    "harmonic_problem",
    "linear_modes",
    "pick",
    "quarter_problem",
    "respond",
    "reversible_problem",
    "trace",
    "whirling_problem",
    "whirls_of",
    "whole_problem",
]
