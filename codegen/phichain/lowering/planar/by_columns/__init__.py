"""Derivatives of planar accelerations in the shortest text: the linearised sweeps once, as the body of a loop over columns."""
