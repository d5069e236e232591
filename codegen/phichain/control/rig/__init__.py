"""What a rig's controller needs beside gains: an observer for what it measures, integral action, a table of gains."""

from phichain.control.rig.integral import with_integrals
from phichain.control.rig.observer import Estimator, Sensors, estimator
from phichain.control.rig.output import output_law
from phichain.control.rig.output_table import output_table
from phichain.control.rig.table import gain_table

__all__ = ["Estimator", "Sensors", "estimator", "gain_table", "output_law", "output_table", "with_integrals"]
