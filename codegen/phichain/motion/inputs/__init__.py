"""Inputs in time: constants, laws u(t, x), tables, laws that sample; with their limits, and where they break."""

from phichain.motion.inputs.given import Input, as_input
from phichain.motion.inputs.legs import Leg, Legs
from phichain.motion.inputs.table import Table

__all__ = ["Input", "Leg", "Legs", "Table", "as_input"]
