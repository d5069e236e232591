"""Orbits without all symmetries of brake orbits: which problem closes each kind, its multipliers, its events,
and its starts."""
