"""Planar sweeps from both ends at once, which halves the chain of dependent operations: side by side, or as two lanes of one loop."""
