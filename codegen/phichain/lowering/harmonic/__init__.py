"""The harmonic-balance equations of planar chains and their Jacobian as Programs."""
