"""Swing-up and point-to-point motion: optimal control on the emitted functions, gains along the motion, one law of both."""

from phichain.control.swing_up.chain import Chain
from phichain.control.swing_up.gains import Design, law_along
from phichain.control.swing_up.plan import Plan
from phichain.control.swing_up.solve import Left, Start, planned, starts
from phichain.control.swing_up.task import Task

__all__ = ["Chain", "Design", "Left", "Plan", "Start", "Task", "law_along", "planned", "starts"]
