"""Simulation: initial value problems of a System by any integrator behind one interface."""

from phichain.motion.events import Crossing, Event
from phichain.motion.run import METHODS, simulate
from phichain.motion.trajectory import Trajectory

__all__ = ["METHODS", "Crossing", "Event", "Trajectory", "simulate"]
