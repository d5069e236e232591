"""Derivatives of the spatial accelerations from one factorisation."""
