"""Functions of one state, and of many at once, timed from C."""
