"""Brake orbits over a quarter period: the problem, the quarter map, and both as a compiled object has them."""

from phichain.orbits.quarter.map import QuarterMap, complement, ordered, quarter_map
from phichain.orbits.quarter.problem import EPS, frequency_error, powers, quarter_problem

__all__ = ["EPS", "QuarterMap", "complement", "frequency_error", "ordered", "powers", "quarter_map", "quarter_problem"]
