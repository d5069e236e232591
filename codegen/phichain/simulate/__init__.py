"""Simulation: initial value problems of a System by any integrator behind one interface."""

from phichain.simulate.events import Crossing, Event
from phichain.simulate.run import METHODS, simulate
from phichain.simulate.trajectory import Trajectory

__all__ = ["METHODS", "Crossing", "Event", "Trajectory", "simulate"]
