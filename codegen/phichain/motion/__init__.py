"""Simulation: initial value problems of a System by any integrator behind one interface."""

from phichain.motion.events import Crossing, Event
from phichain.motion.inputs import Table
from phichain.motion.methods.registry import METHODS
from phichain.motion.run import simulate
from phichain.motion.trajectory import Trajectory

__all__ = ["METHODS", "Crossing", "Event", "Table", "Trajectory", "simulate"]
