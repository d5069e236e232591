"""Mechanics: kinematics -> T, V -> Lagrangian -> coefficients and equations; equilibria; linearisation.

"Theory section n" in docstrings means section n of docs/theory.md; bare numbers (15) are the papers'.
"""

from phichain.mechanics.lagrange import Model, derive, with_symbols

__all__ = ["Model", "derive", "with_symbols"]
