"""Derivatives of spatial accelerations from one factorisation."""
