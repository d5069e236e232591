"""Control: equilibria, controllability with its margin, linear regulators and what a rig needs beside them, computed torque."""

from phichain.control.computed_torque import computed_torque, in_phase, tracking_error
from phichain.control.controllability import Controllability, controllability
from phichain.control.equilibria import Equilibrium, equilibria, equilibrium
from phichain.control.exchange import from_control, to_control
from phichain.control.feedback import deviation, errors, feedback
from phichain.control.gains import Gains
from phichain.control.linear import LinearSystem, linearize
from phichain.control.placement import place, with_gains
from phichain.control.regulators import lqr, regulators
from phichain.control.rig import (
    Estimator,
    Sensors,
    estimator,
    gain_table,
    output_law,
    output_table,
    with_integrals,
)

__all__ = [
    "Controllability",
    "Equilibrium",
    "Estimator",
    "Gains",
    "LinearSystem",
    "Sensors",
    "computed_torque",
    "controllability",
    "deviation",
    "equilibria",
    "equilibrium",
    "errors",
    "estimator",
    "feedback",
    "from_control",
    "gain_table",
    "in_phase",
    "linearize",
    "lqr",
    "output_law",
    "output_table",
    "place",
    "regulators",
    "to_control",
    "tracking_error",
    "with_gains",
    "with_integrals",
]
