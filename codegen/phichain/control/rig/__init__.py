"""What a rig's controller needs beside gains: an observer for what it measures, integral action, a table of gains."""

from phichain.control.rig.integral import with_integrals
from phichain.control.rig.observer import Estimator, Sensors, estimator
from phichain.control.rig.output import output_law

__all__ = ["Estimator", "Sensors", "estimator", "output_law", "with_integrals"]
