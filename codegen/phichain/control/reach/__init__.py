"""How far a regulator holds: regions of attraction by simulation of the emitted closed loop, with maps of them."""

from phichain.control.reach.attraction import attraction
from phichain.control.reach.map import AttractionMap, attraction_map, demand_turns
from phichain.control.reach.record import Attraction

__all__ = ["Attraction", "AttractionMap", "attraction", "attraction_map", "demand_turns"]
