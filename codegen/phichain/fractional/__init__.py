"""The fractional view of paper A: powers of matrices, differintegrals of signals, and both along a motion.

surface = differintegrate(t, theta_ddot, alpha, order=4)             # D^alpha, all alpha at once
powers = inertia_powers(inertia_spectrum(system, q), u, p)           # (I^-1)^p u, all p at once
picture = propagation(system, trajectory.resample(2001), p, alpha)   # both, along a motion
"""

from phichain.fractional.differintegral import Differintegral, differintegrate, grunwald_letnikov
from phichain.fractional.factor import inertia_factor
from phichain.fractional.inertia import InertiaSpectrum, factor_spectrum, inertia_powers, inertia_spectrum
from phichain.fractional.matrix import (
    MatrixPowerError,
    NearDefectiveWarning,
    Spectrum,
    eigenvectors,
    matrix_power,
)
from phichain.fractional.memory import ShortMemory, implied_error, memory_length, short_memory
from phichain.fractional.propagation import PATHS, Motion, Propagation, propagation

__all__ = [
    "PATHS",
    "Differintegral",
    "InertiaSpectrum",
    "MatrixPowerError",
    "Motion",
    "NearDefectiveWarning",
    "Propagation",
    "ShortMemory",
    "Spectrum",
    "differintegrate",
    "eigenvectors",
    "factor_spectrum",
    "grunwald_letnikov",
    "implied_error",
    "inertia_factor",
    "inertia_powers",
    "inertia_spectrum",
    "matrix_power",
    "memory_length",
    "propagation",
    "short_memory",
]
