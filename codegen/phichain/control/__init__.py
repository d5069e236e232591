"""Control: equilibria, controllability with its margin, linear regulators, and their control law."""

from phichain.control.controllability import Controllability, controllability
from phichain.control.equilibria import Equilibrium, equilibria, equilibrium
from phichain.control.feedback import deviation, errors, feedback
from phichain.control.gains import Gains, lqr
from phichain.control.linear import LinearSystem, linearize

__all__ = [
    "Controllability",
    "Equilibrium",
    "Gains",
    "LinearSystem",
    "controllability",
    "deviation",
    "equilibria",
    "equilibrium",
    "errors",
    "feedback",
    "linearize",
    "lqr",
]
