"""Trajectories: Taylor flows of one state and of many, their derivatives, and who else integrates."""
