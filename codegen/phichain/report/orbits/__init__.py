"""Families of orbits and single orbits: drawn with their events, and in motion."""
