"""Planar accelerations where room is dear: the ends of the articulated sweep in fewer operations."""
