"""Chaotic motions: the error that a simulation estimates beside the one it has."""
