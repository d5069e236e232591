"""Orbits of spatial chains that come back turned about the vertical, and that no mirror image is the reversal of."""

from phichain.orbits.unmirrored.family import START, from_whirl, settings, trace_unmirrored
from phichain.orbits.unmirrored.problem import METHOD, problem_of_branch, unmirrored_problem

__all__ = ["METHOD", "START", "from_whirl", "problem_of_branch", "settings", "trace_unmirrored", "unmirrored_problem"]
