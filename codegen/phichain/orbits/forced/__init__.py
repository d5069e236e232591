"""Periodic motions of chains that A cos(omega t) drives: amplitude against frequency through folds, with their stability."""

from phichain.orbits.forced.forcing import Forcing
from phichain.orbits.forced.respond import respond
from phichain.orbits.forced.response import Response, ResponseEvent

__all__ = ["Forcing", "Response", "ResponseEvent", "respond"]
