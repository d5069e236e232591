"""Mechanics: chain kinematics -> T, V -> Lagrangian -> coefficients and equations; equilibria; linearisation (19)."""

from phichain.mechanics.lagrange import Model, derive, with_symbols

__all__ = ["Model", "derive", "with_symbols"]
