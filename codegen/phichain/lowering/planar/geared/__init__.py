"""Planar chains whose joints carry rotors: a couple A_k times the relative angular acceleration goes across every joint."""
