"""Orbits and events of families followed in a parameter of the chain."""

from phichain.orbits.parameter.knob import Knob, knob_of
from phichain.orbits.parameter.vary import vary

__all__ = ["Knob", "knob_of", "vary"]
