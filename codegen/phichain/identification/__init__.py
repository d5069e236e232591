"""Identification: the runtime parameters of a chain from a measured motion, with what the data can say of them."""

from phichain.identification.fit import fit
from phichain.identification.measurement import Measurement, read_measurement
from phichain.identification.record import Fit

__all__ = ["Fit", "Measurement", "fit", "read_measurement"]
