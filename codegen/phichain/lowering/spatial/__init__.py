"""Chains in space: unit vectors, and the sweeps over them."""
