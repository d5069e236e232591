"""Chains in the plane: angles, and the sweeps over them."""
