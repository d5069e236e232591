"""Whirling families: orbits of spatial chains that come back turned about the vertical."""

from phichain.orbits.whirling.families import trace_whirling
from phichain.orbits.whirling.problem import HELD, whirling_problem
from phichain.orbits.whirling.starts import METHOD, NEEDED, Whirl, whirls_of

__all__ = ["HELD", "METHOD", "NEEDED", "Whirl", "trace_whirling", "whirling_problem", "whirls_of"]
