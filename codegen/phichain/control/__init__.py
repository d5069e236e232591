"""Control: equilibria, controllability with its margin, linear regulators and their law, computed torque."""

from phichain.control.computed_torque import computed_torque, in_phase, tracking_error
from phichain.control.controllability import Controllability, controllability
from phichain.control.equilibria import Equilibrium, equilibria, equilibrium
from phichain.control.feedback import deviation, errors, feedback
from phichain.control.gains import Gains
from phichain.control.linear import LinearSystem, linearize
from phichain.control.regulators import lqr, regulators

__all__ = [
    "Controllability",
    "Equilibrium",
    "Gains",
    "LinearSystem",
    "computed_torque",
    "controllability",
    "deviation",
    "equilibria",
    "equilibrium",
    "errors",
    "feedback",
    "in_phase",
    "linearize",
    "lqr",
    "regulators",
    "tracking_error",
]
