"""Harmonic balance: the equations of motion projected on one harmonic, in closed form for any N."""

from phichain.harmonic.paper import phi_latex, phi_text, printed_equations
from phichain.harmonic.projection import OMEGA, Kernels, amplitude_symbols, kernels, phi_expressions

__all__ = [
    "OMEGA",
    "Kernels",
    "amplitude_symbols",
    "kernels",
    "phi_expressions",
    "phi_latex",
    "phi_text",
    "printed_equations",
]
